#include "engine/scenes/scene_control.h"

#include <algorithm>

#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/scenes/drive_file.h"

namespace thenar {

using Eigen::Vector3d;

PidGains read_gains(const ConfigMap& map) { return {map.quantity("p"), map.quantity("i"), map.quantity("d")}; }

namespace {

/// The friction of the cones: a number, or felt.
void read_cones(const ConfigMap& grasp, ControlSettings& control) {
  if (grasp.word("friction") == "felt") {
    control.felt_margin = grasp.quantity("margin");
    control.grasp_friction = grasp.quantity("first_friction") / (1.0 + *control.felt_margin);
    return;
  }
  control.grasp_friction = grasp.quantity("friction");
  if (grasp.is_refused("friction")) return;
  for (const char* key : {"margin", "first_friction"}) {
    if (grasp.has(key)) grasp.refuse(key, "counts with friction: felt alone");
  }
}

ReflexSettings read_reflex(const ConfigMap& map) {
  return {map.quantity("load_rate"), map.quantity("pulse"), map.quantity("release"), map.quantity("stick"),
          map.quantity("regulation")};
}

ObjectStiffness read_object_stiffness(const ConfigMap& map) {
  ObjectStiffness wanted{map.quantities("translation"), map.quantities("rotation")};
  if (map.has("centre")) wanted.centre_m = map.quantities("centre");
  if (map.has("squeeze")) wanted.most_squeeze_N = map.quantity("squeeze");
  return wanted;
}

/// Muscles by themselves, as torques, or with what they are.
std::optional<MuscleSettings> read_muscles(const ConfigMap& control, const Hand& hand) {
  if (const std::string word = control.word("muscles"); !word.empty()) {
    return word == "true" ? std::optional(MuscleSettings{}) : std::nullopt;
  }
  const ConfigMap map = control.map("muscles");
  MuscleSettings muscles;
  if (map.has("activation")) muscles.activation = Activation{map.quantity("activation"), map.quantity("deactivation")};
  if (map.has("deactivation") && !map.has("activation"))
    map.refuse("deactivation", "goes with activation: name that, too");
  if (map.has("stiffness")) {
    muscles.short_range = map.quantity("stiffness");
    const auto without = std::ranges::find_if(hand.muscles, [](const Muscle& m) { return !m.fibre_m; });
    if (without != hand.muscles.end()) {
      map.refuse("stiffness",
                 "needs the fibre_length of each muscle, and the hand does not say that of " + without->name);
    }
  }
  if (map.has("object_stiffness")) {
    muscles.object_stiffness = read_object_stiffness(map.map("object_stiffness"));
    if (!map.has("stiffness")) map.refuse("object_stiffness", "is made of the muscles' stiffness: name that, too");
  }
  if (map.has("frozen_from")) {
    muscles.frozen_from_s = map.quantity("frozen_from");
  }
  return muscles;
}

}  // namespace

ControlSettings read_control(const ConfigMap& map, const Hand& hand, bool pressed, bool feels) {
  ControlSettings control;
  control.law = map.choice("law") == "paper" ? ControlLaw::kPaper : ControlLaw::kFeedforward;
  if (map.word("gain").empty()) control.gain = map.quantity("gain");
  const ConfigMap pulp = map.map("pulp");
  control.pulp_normal_N_per_m = pulp.quantity("normal");
  control.pulp_tangential_N_per_m = pulp.quantity("tangential");
  const ConfigMap grasp = map.map("grasp");
  read_cones(grasp, control);
  if (!pressed) {
    control.internal_force_N = grasp.quantity("internal_force");
  } else if (grasp.has("internal_force")) {
    grasp.refuse("internal_force", "is what grasp.press asks for: leave out one of them");
  }
  control.cone = grasp.choice("cone") == "exact" ? FrictionCone::kExact : FrictionCone::kPyramid;
  control.position = read_gains(map.map("position"));
  control.rotation = read_gains(map.map("rotation"));
  if (map.has("centre")) control.centre_m = map.quantities("centre");
  if (map.has("posture")) control.posture_Nm_per_rad = map.quantity("posture");
  if (map.has("feedback_delay")) control.feedback_delay_s = map.quantity("feedback_delay");
  if (map.has("anticipation")) control.anticipation = map.flag("anticipation");
  if (control.felt_margin && !feels) grasp.refuse("friction", "felt needs fingertips.touch");
  if (map.has("reflex")) {
    control.reflex = read_reflex(map.map("reflex"));
    if (!feels) map.refuse("reflex", "needs fingertips.touch");
  }
  control.muscles = read_muscles(map, hand);
  return control;
}

bool read_drive(const ConfigMap& map, const Hand& hand, ControlSettings& control) {
  const std::filesystem::path file = map.path("drive");
  if (file.empty() || hand.joints.empty()) return true;
  try {
    control.drive = load_drive(file, hand);
  } catch (const ReadError& error) {
    map.refuse("drive", error.what());
    return false;
  } catch (const FileError& error) {
    map.refuse("drive", error.what());
  }
  if (control.drive && control.drive->muscles && !control.muscles) {
    map.refuse("drive", "has muscle forces, which need control.muscles: true");
  }
  return true;
}

}  // namespace thenar
