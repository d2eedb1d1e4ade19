// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "engine/finder/hand_body.h"
#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/scenes/config.h"
#include "engine/scenes/describe.h"
#include "engine/scenes/key_table.h"
#include "engine/scenes/object_bounds.h"
#include "engine/scenes/scene_file.h"

/// The map `grasp` of a scene: a grasp to be found, or one that another scene has.
namespace thenar {

namespace fs = std::filesystem;

using enum Dimension;

namespace {

/// What is asked of a grasp beside the word `auto`.
void describe_wish(Visitor& v, const Scene& scene, GraspWish& wish, bool is_controlled) {
  std::vector<std::string> names = names_of(scene.hand, wish.fingers);
  v.key({"fingers", kNone, "", "(Without it all of them, or as many as find a place.)",
         "The fingers that are to hold, by name; the others are left out of the scene."},
        names);
  if (v.reads()) wish.fingers = fingers_named(v, scene.hand, names);
  describe_direction(v,
                     {"axis", kNone, "", "(Without it any.)",
                      "The line on which the fingers face each other, in the object's axes, of any length but zero."},
                     wish.axis_O);
  v.key({"at", kLength, "", "(Without it anywhere.)",
         "Near which point of the object frame, half-way between the fingers, it is held."},
        wish.at_O);
  if (wish.at_O) check_is_in_object(v, "at", *wish.at_O, scene.object.shape);
  describe_direction(v,
                     {"approach", kNone, "", "(Without it any.)",
                      "The way in which the hand comes to the object, in the object's axes, of any length but zero."},
                     wish.approach_O);
  v.key({"press", kForce, "> 0", "(Required without control; else control.grasp.internal_force.)",
         "The normal load of the least loaded finger, under the weight at rest."},
        wish.press_N, !is_controlled);
  v.key({"rank", kNone, "1 .. 20", "1", "Which of the grasps that are found: 1 is the best."}, wish.rank);
  v.key({"seed", kNone, "0 .. 1000000", "1", "The seed of the search: the same one finds the same grasp."}, wish.seed);
}

/// Tests whether two files are one, or have the same bytes.
bool are_same_file(const fs::path& one, const fs::path& other) {
  std::error_code none;
  return fs::equivalent(one, other, none) || (!one.empty() && !other.empty() && read_file(one) == read_file(other));
}

bool are_same_shape(const Shape& one, const Shape& other) {
  const auto *a = std::get_if<CloudShape>(&one), *b = std::get_if<CloudShape>(&other);
  if (a == nullptr || b == nullptr) return one == other;
  return a->unit_m == b->unit_m && are_same_file(a->file, b->file);
}

std::string name_of_shape(const Shape& shape) {
  constexpr std::string_view kNames[]{"box", "sphere", "ellipsoid", "cylinder", "superquadric", "mug"};
  if (const auto* cloud = std::get_if<CloudShape>(&shape)) return printable(cloud->file.string());
  return fmt::format("another {}", kNames[shape.index()]);
}

/// The scene whose grasp is taken. Throws ConfigError where it has no posture, and what load_scene() throws.
Scene scene_with_posture(const fs::path& file) {
  const Config config(file, scene_keys());
  if (config.root().has("grasp")) {
    throw ConfigError({{printable(file.string()), "grasp",
                        "asks for a grasp to be found, and has no posture: thenar grasp " + printable(file.string()) +
                            " --out grasps writes grasps/grasp-1.yaml, which has one"}});
  }
  Scene scene = load_scene(file);
  if (scene.hand.slides) {
    throw ConfigError({{printable(file.string()), "hand.slides", "is no hand, and has no posture"}});
  }
  return scene;
}

/// Takes a grasp from a scene that has it: fingers, posture, the object's pose, and without control the torques.
/// Refuses one of another hand or object.
void take(Visitor& v, const Scene& from, const fs::path& from_hand, SceneFile& file, bool is_controlled) {
  Scene& scene = file.scene;
  if (scene.hand.joints.empty()) return;  // No hand was read, and that is reported.
  if (!are_same_file(from_hand, file.hand) || from.hand.mirrored != scene.hand.mirrored) {
    const bool is_mirrored = are_same_file(from_hand, file.hand);
    return v.refuse("from", is_mirrored ? "has the grasp of the other hand: hand.mirror differs"
                                        : fmt::format("has the grasp of another hand, {}, and this scene has {}",
                                                      printable(from_hand.string()), printable(file.hand.string())));
  }
  if (!are_same_shape(from.object.shape, scene.object.shape)) {
    return v.refuse("from", fmt::format("has the grasp of another object, {}: its object.shape differs",
                                        name_of_shape(from.object.shape)));
  }
  std::vector<int> fingers;
  for (const Fingertip& tip : from.hand.fingertips) {
    const auto same = std::ranges::find(scene.hand.fingertips, tip.finger, &Fingertip::finger);
    if (same == scene.hand.fingertips.end()) {
      return v.refuse("from", "holds with the " + tip.finger + ", which hand.fingers leaves out here");
    }
    fingers.push_back(static_cast<int>(same - scene.hand.fingertips.begin()));
  }
  if (!is_controlled && !from.torques) {
    return v.refuse("from", "has control, and no hand.torques, which a scene without control needs");
  }
  scene.hand = hand_of(scene.hand, fingers);
  scene.posture = from.posture;
  scene.object.X_WO = from.object.X_WO;
  scene.settles = true;
  if (!is_controlled) scene.torques = from.torques;
  file.taken_squeeze_N.reset();
  if (from.control) file.taken_squeeze_N = from.control->internal_force_N;
}

/// Reads the scene at `path`, and takes its grasp.
void take_from(Visitor& v, const fs::path& path, SceneFile& file, bool is_controlled) {
  file.taken_squeeze_N = 0.0;  // Of a grasp that is refused no squeeze is missing.
  if (path.empty()) return;
  try {
    const Scene from = scene_with_posture(path);
    take(v, from, scene_files(path, {})[1], file, is_controlled);
  } catch (const ConfigError& error) {
    const std::string faults = error.what();
    v.refuse("from", faults.substr(0, faults.find('\n')));
  } catch (const ReadError& error) {
    v.refuse("from", error.what());
    file.is_readable = false;
  }
}

}  // namespace

void describe_grasp(Visitor& v, SceneFile& file, bool is_controlled) {
  Scene& scene = file.scene;
  const KeyRow row{"grasp", kNone, " | auto", "(Without it hand and object begin where the scene places them.)",
                   "A grasp that is found: which fingers hold the object where, with what posture, and how the object "
                   "lies in the hand. What is not named here is chosen. Or one that is taken from another scene."};
  GraspWish wish = scene.grasp.value_or(GraspWish{.place = v.location("grasp")});
  GraspWish nothing;
  nothing.place = wish.place;
  bool is_taken = false;
  if (v.word(row, wish == nothing ? "auto" : "").empty()) {
    v.map(row, [&] {
      fs::path from;
      v.key({"from", kNone, "", "(Without it a grasp is searched for.)",
             "A scene with a posture, as thenar grasp --out writes it, whose grasp is taken instead: fingers, posture "
             "and the object's pose, and without control.grasp.internal_force its squeeze. It needs no other key of "
             "grasp."},
            from);
      is_taken = v.has("from");
      if (is_taken) take_from(v, from, file, is_controlled);
      if (v.when(!is_taken)) describe_wish(v, scene, wish, is_controlled);
    });
  } else if (!is_controlled) {
    v.refuse("grasp", "needs grasp.press without control: write it as a map");
  }
  if (!is_taken) scene.grasp = wish;
}

}  // namespace thenar
