#include "engine/scenes/scene_control.h"

#include <algorithm>

#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/scenes/drive_file.h"
#include "engine/scenes/object_bounds.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

PidGains read_gains(const ConfigMap& map) { return {map.quantity("p"), map.quantity("i"), map.quantity("d")}; }

Move read_translation(const ConfigMap& map) {
  Move move;
  const Vector3d by = map.quantities("by");
  move.amount = by.norm();
  if (move.amount > 0.0) move.axis = by / move.amount;
  move.from_s = map.quantity("from");
  move.over_s = map.quantity("over");
  return move;
}

Move read_rotation_move(const ConfigMap& map) {
  Move move;
  move.amount = map.quantity("by");
  const Vector3d about = map.quantities("about");
  if (about.squaredNorm() <= 0.0) map.refuse("about", "an axis must not be zero");
  move.axis = about.stableNormalized();
  move.from_s = map.quantity("from");
  move.over_s = map.quantity("over");
  return move;
}

Push read_push(const ConfigMap& map, const Shape& shape) {
  Push push;
  // One of the two is asked for: the force, unless there is a moment.
  if (map.has("force") || !map.has("moment")) push.force_N = map.quantities("force");
  if (map.has("at")) {
    push.at_m = map.quantities("at");
    check_is_in_object(map, "at", push.at_m, shape);
    if (!map.has("force")) map.refuse("at", "is where a force acts, and there is none: name it, or leave this out");
  }
  if (map.has("moment")) push.moment_Nm = map.quantities("moment");
  push.from_s = map.quantity("from");
  push.over_s = map.quantity("over");
  if (map.has("rise")) push.rise_s = map.quantity("rise");
  if (push.rise_s > push.over_s) map.refuse("rise", "must not take longer than the push");
  return push;
}

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

Arm read_arm(const ConfigMap& map) {
  Arm arm;
  const Vector3d along = map.quantities("along");
  if (along.squaredNorm() <= 0.0) map.refuse("along", "a line must not be zero");
  arm.axis = along.stableNormalized();
  arm.amplitude_m = map.quantity("amplitude");
  arm.frequency_Hz = map.quantity("frequency");
  arm.from_s = map.quantity("from");
  arm.over_s = map.quantity("over");
  return arm;
}

std::vector<FrictionStep> read_friction_steps(const ConfigMap& map) {
  std::vector<FrictionStep> steps;
  for (const ConfigMap& step : map.list_of_maps("friction")) {
    steps.push_back({step.quantity("at"), step.quantity("to")});
    if (steps.size() > 1 && !(steps.back().from_s > steps[steps.size() - 2].from_s)) {
      step.refuse("at", "must be later than that of the step before it");
    }
  }
  return steps;
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

TaskSettings read_task(const ConfigMap& map, const Shape& shape) {
  TaskSettings task;
  if (map.has("translate")) task.translate = read_translation(map.map("translate"));
  if (map.has("rotate")) task.rotate = read_rotation_move(map.map("rotate"));
  if (map.has("spring")) {
    const ConfigMap spring = map.map("spring");
    task.spring = Spring{spring.quantity("translation"), spring.quantity("rotation")};
  }
  if (map.has("push")) task.push = read_push(map.map("push"), shape);
  if (map.has("arm")) task.arm = read_arm(map.map("arm"));
  if (map.has("friction")) task.friction = read_friction_steps(map);
  if (map.has("lost")) task.lost_m = map.quantity("lost");
  return task;
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
