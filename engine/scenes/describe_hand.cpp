// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <system_error>
#include <vector>

#include "engine/finder/hand_body.h"
#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/scenes/describe.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/shared_data.h"

/// The map `hand` of a scene where it is no list of slides, and fingers by their names.
namespace thenar {

using enum Dimension;

std::filesystem::path found_hand(const std::filesystem::path& beside) {
  std::error_code none;  // A folder may have the name of a hand.
  if (beside.empty() || (is_readable(beside) && !std::filesystem::is_directory(beside, none))) return beside;
  const std::filesystem::path known = known_hand(beside);
  return known.empty() ? beside : known;
}

namespace {

void read_hand(Visitor& v, SceneFile& file) {
  file.hand = found_hand(file.hand);
  if (file.hand.empty()) return;
  try {
    file.scene.hand = load_hand(file.hand);
  } catch (const ReadError& error) {
    const std::vector<std::string> names = known_hands();
    const std::vector<std::string_view> candidates(names.begin(), names.end());
    v.refuse("model", error.what() + did_you_mean(nearest_word(file.hand.stem().string(), candidates)));
    file.is_readable = false;
  }
}

void check_posture(Visitor& v, const Hand& hand, const JointVector& posture) {
  for (int i = 0; i < posture.size(); ++i) {
    const Joint& joint = hand.joints[i];
    if (posture[i] >= joint.lower_rad && posture[i] <= joint.upper_rad) continue;
    constexpr double kDegree = std::numbers::pi / 180.0;
    v.refuse("posture", fmt::format("value {} ({}) is {:.4g} rad and must lie within {:.4g} .. {:.4g} rad, "
                                    "{:.3g} .. {:.3g} deg",
                                    i + 1, joint.name, posture[i], joint.lower_rad, joint.upper_rad,
                                    joint.lower_rad / kDegree, joint.upper_rad / kDegree));
  }
}

void describe_posture(Visitor& v, Scene& scene) {
  Eigen::VectorXd posture = scene.posture;
  v.per_joint({"posture", kAngle, "", "(Required without grasp and slides, refused with one of them.)",
               "The joint angles at the start, in the order of the hand file, each within its joint's limits; none for "
               "a joint that follows another one."},
              posture, std::ssize(scene.hand.joints));
  if (scene.hand.joints.empty()) return;  // No hand was read, and that is reported.
  scene.posture = posture;
  check_posture(v, scene.hand, scene.posture);
}

void describe_torques(Visitor& v, SceneFile& file) {
  Scene& scene = file.scene;
  Eigen::VectorXd torques_Nm = scene.torques.value_or(scene.hand.at_zero());
  v.per_joint({"torques", kTorque, "", "(Required without control, grasp and slides, refused with one of them.)",
               "The constant joint torques of a scene without control."},
              torques_Nm, std::ssize(scene.hand.joints));
  if (v.reads() && file.is_readable) scene.torques = torques_Nm;
}

}  // namespace

std::vector<std::string> names_of(const Hand& hand, const std::vector<int>& fingers) {
  std::vector<std::string> names;
  for (const int k : fingers) names.push_back(hand.fingertips[k].finger);
  return names;
}

std::vector<int> fingers_named(Visitor& v, const Hand& hand, const std::vector<std::string>& names) {
  std::vector<int> fingers;
  std::vector<std::string_view> known;
  for (const Fingertip& tip : hand.fingertips) known.push_back(tip.finger);
  if (known.empty()) return fingers;  // No hand was read, and that is reported.
  for (const std::string& name : names) {
    const auto tip = std::ranges::find(known, name);
    const int k = static_cast<int>(tip - known.begin());
    if (tip == known.end()) {
      v.refuse("fingers", "the hand has no finger '" + name + "'" + did_you_mean(nearest_word(name, known)));
    } else if (std::ranges::find(fingers, k) != fingers.end()) {
      v.refuse("fingers", "names '" + name + "' twice");
    } else {
      fingers.push_back(k);
    }
  }
  return fingers;
}

void describe_hand(Visitor& v, SceneFile& file, bool is_found, bool is_controlled) {
  Scene& scene = file.scene;
  bool mirror = scene.hand.mirrored;
  v.key({"model", kNone, "", "(Required without slides, refused with them.)",
         "The hand file: bones, joints, fingertips and muscles. Beside the scene, or one that comes with the program."},
        file.hand);
  if (v.reads()) read_hand(v, file);
  v.key({"fingers", kNone, "", "(Without it the hand has all of its fingers.)",
         "The fingers that the hand has here, by name; the others are left out, with their joints and muscles."},
        file.fingers);
  v.key({"mirror", kNone, "", "(Without it the hand is as its file has it.)",
         "Whether it is the other hand, left for right: the mirror image in the plane z = 0 of the hand frame."},
        mirror);
  if (v.reads()) {
    const std::vector<int> fingers = fingers_named(v, scene.hand, file.fingers);
    if (!fingers.empty()) scene.hand = hand_of(scene.hand, fingers);
    if (mirror) scene.hand = mirrored(std::move(scene.hand));
    scene.posture = scene.hand.at_zero();
  }
  if (is_found) refuse_found(v, {"posture"});
  if (v.when(!is_found)) describe_posture(v, scene);
  v.key({"settle", kNone, "", "(Without it the fingers are where the posture has them. A grasp that is found settles.)",
         "Whether the fingers move along the object's normals, before the time begins, until they press with what they "
         "are asked for: a posture by hand need not be right to a tenth of a millimetre."},
        scene.settles);
  v.key({"joint_viscosity", kRotationalDamping, "> 0", "(Required without slides, refused with them.)",
         "The viscous damping b of every joint."},
        scene.joint_viscosity);
  if (v.when(!is_controlled && !is_found)) describe_torques(v, file);
}

}  // namespace thenar
