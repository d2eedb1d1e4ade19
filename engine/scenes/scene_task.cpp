#include "engine/scenes/scene_task.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/control/task_order.h"
#include "engine/scenes/object_bounds.h"
#include "engine/scenes/scene_control.h"
#include "engine/scenes/units.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

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

/// After so long beyond its way, or what else takes so long, a phase has failed.
constexpr double kPatience_s = 10.0;

double read_within(const ConfigMap& map, double least_s) {
  if (!map.has("within")) return least_s + kPatience_s;
  const double within_s = map.quantity("within");
  if (within_s < least_s) map.refuse("within", fmt::format("must not be less than the {:g} s that it takes", least_s));
  return within_s;
}

void read_arm_way(const ConfigMap& map, Phase& phase) {
  phase.by_m = map.quantities("by");
  phase.over_s = map.quantity("over");
}

Phase read_phase(const ConfigMap& map) {
  using Kind = Phase::Kind;
  const std::string name = map.one_of();
  if (name.empty()) return {};
  const ConfigMap of = map.map(name);
  Phase phase;
  if (name == "insert") {
    phase = {.kind = Kind::kInsert, .most_N = of.quantity("most_force")};
    read_arm_way(of, phase);
    if (of.has("position")) phase.position = read_gains(of.map("position"));
    if (of.has("rotation")) phase.rotation = read_gains(of.map("rotation"));
    if (of.has("centre")) phase.centre_m = of.quantities("centre");
  } else if (name == "close") {
    phase = {.kind = Kind::kClose, .press_N = of.quantity("press"), .speed_m_per_s = of.quantity("speed")};
  } else if (name == "release") {
    phase = {.kind = Kind::kRelease, .speed_m_per_s = of.quantity("speed"), .open_m = of.quantity("open")};
  } else if (name == "load") {
    phase = {.kind = Kind::kLoad, .over_s = of.quantity("over")};
  } else {
    for (const Kind kind : {Kind::kApproach, Kind::kLift, Kind::kMove, Kind::kPlace}) {
      if (name == to_string(kind)) phase.kind = kind;
    }
    read_arm_way(of, phase);
  }
  const bool opens = phase.kind == Kind::kRelease && phase.speed_m_per_s > 0.0;
  phase.within_s = read_within(of, opens ? phase.open_m / phase.speed_m_per_s : phase.over_s);
  return phase;
}

std::vector<Phase> read_phases(const ConfigMap& root, const ConfigMap& task, const Scene& scene) {
  std::vector<Phase> phases;
  const std::vector<ConfigMap> maps = task.list_of_maps("phases");
  for (const ConfigMap& phase : maps) phases.push_back(read_phase(phase));
  if (phases.empty() && !task.is_refused("phases")) task.refuse("phases", "names no phase");
  for (std::size_t i = 0; i < phases.size() && !task.is_refused("phases"); ++i) {
    const std::string fault = order_fault(phases, i);
    if (!fault.empty()) maps[i].refuse(to_string(phases[i].kind), fault);
  }
  const auto refuse_if = [&](bool wrong, const char* why) {
    if (wrong) task.refuse("phases", why);
  };
  const auto has = [&](Phase::Kind kind) { return std::ranges::find(phases, kind, &Phase::kind) != phases.end(); };
  refuse_if(!root.has("control"), "needs control, which goes through them");
  refuse_if(!root.has("environment"), "needs an environment, by which the arm goes");
  refuse_if(scene.gravity.isZero(0.0) && has(Phase::Kind::kPlace),
            "place needs gravity: the weight tells what is borne");
  refuse_if(!scene.fingertips && has(Phase::Kind::kClose), "close needs fingertips: rigid ones meet with any force");
  refuse_if(scene.control && scene.control->law == ControlLaw::kPaper, "need control.law: feedforward");
  refuse_if(scene.control && scene.control->drive, "needs the control law: leave out control.drive");
  for (const char* key : {"translate", "rotate", "spring"}) {
    if (task.has(key)) task.refuse(key, "moves the target by time: phases hold the object where they took it");
  }
  return phases;
}

}  // namespace

TaskSettings read_task(const ConfigMap& root, const Scene& scene) {
  const ConfigMap map = root.map("task");
  TaskSettings task;
  if (map.has("translate")) task.translate = read_translation(map.map("translate"));
  if (map.has("rotate")) task.rotate = read_rotation_move(map.map("rotate"));
  if (map.has("spring")) {
    const ConfigMap spring = map.map("spring");
    task.spring = Spring{spring.quantity("translation"), spring.quantity("rotation")};
  }
  if (map.has("push")) task.push = read_push(map.map("push"), scene.object.shape);
  if (map.has("arm")) task.arm = read_arm(map.map("arm"));
  if (map.has("friction")) task.friction = read_friction_steps(map);
  if (map.has("phases")) task.phases = read_phases(root, map, scene);
  if (map.has("lost")) task.lost_m = map.quantity("lost");
  return task;
}

namespace {

std::string insertion_text(const Phase& phase) {
  std::string out = fmt::format(", most_force: {}", to_text(phase.most_N, Dimension::kForce));
  const auto add = [&](const char* key, const std::optional<PidGains>& gains, Dimension p, Dimension i, Dimension d) {
    if (!gains) return;
    out += fmt::format(", {}: {{p: {}, i: {}, d: {}}}", key, to_text(gains->p, p), to_text(gains->i, i),
                       to_text(gains->d, d));
  };
  using enum Dimension;
  add("position", phase.position, kStiffness, kIntegralGain, kDamping);
  add("rotation", phase.rotation, kRotationalStiffness, kRotationalIntegralGain, kRotationalDamping);
  if (phase.centre_m) out += ", centre: " + to_text(*phase.centre_m, Dimension::kLength);
  return out;
}

std::string phase_text(const Phase& phase) {
  const auto speed = [&] { return to_text(phase.speed_m_per_s, Dimension::kSpeed); };
  std::string keys;
  switch (phase.kind) {
    case Phase::Kind::kClose:
      keys = fmt::format("press: {}, speed: {}", to_text(phase.press_N, Dimension::kForce), speed());
      break;
    case Phase::Kind::kRelease:
      keys = fmt::format("open: {}, speed: {}", to_text(phase.open_m, Dimension::kLength), speed());
      break;
    case Phase::Kind::kLoad:
      keys = fmt::format("over: {}", to_text(phase.over_s, Dimension::kTime));
      break;
    default:
      keys = fmt::format("by: {}, over: {}", to_text(phase.by_m, Dimension::kLength),
                         to_text(phase.over_s, Dimension::kTime));
  }
  if (phase.kind == Phase::Kind::kInsert) keys += insertion_text(phase);
  return fmt::format("    - {}: {{{}, within: {}}}\n", to_string(phase.kind), keys,
                     to_text(phase.within_s, Dimension::kTime));
}

}  // namespace

std::string task_text(const TaskSettings& task) {
  std::string out;
  const auto times = [](double from_s, double over_s) {
    return fmt::format("from: {}, over: {}", to_text(from_s, Dimension::kTime), to_text(over_s, Dimension::kTime));
  };
  if (const auto& move = task.translate) {
    out += fmt::format("  translate: {{by: {}, {}}}  # object axes at the start\n",
                       to_text(Vector3d(move->amount * move->axis), Dimension::kLength),
                       times(move->from_s, move->over_s));
  }
  if (const auto& move = task.rotate) {
    out += fmt::format("  rotate: {{by: {}, about: {}, {}}}\n", to_text(move->amount, Dimension::kAngle),
                       to_text(move->axis, Dimension::kNone), times(move->from_s, move->over_s));
  }
  if (const auto& spring = task.spring) {
    out += fmt::format("  spring: {{translation: {}, rotation: {}}}\n",
                       to_text(spring->translation_N_per_m, Dimension::kStiffness),
                       to_text(spring->rotation_Nm_per_rad, Dimension::kRotationalStiffness));
  }
  if (const auto& push = task.push) {
    const std::string moment =
        push->moment_Nm.isZero(0.0) ? "" : fmt::format("moment: {}, ", to_text(push->moment_Nm, Dimension::kTorque));
    const std::string rise =
        push->rise_s > 0.0 ? fmt::format(", rise: {}", to_text(push->rise_s, Dimension::kTime)) : "";
    out += fmt::format("  push: {{force: {}, at: {}, {}{}{}}}\n", to_text(push->force_N, Dimension::kForce),
                       to_text(push->at_m, Dimension::kLength), moment, times(push->from_s, push->over_s), rise);
  }
  if (const auto& arm = task.arm) {
    out += fmt::format("  arm: {{along: {}, amplitude: {}, frequency: {}, {}}}\n", to_text(arm->axis, Dimension::kNone),
                       to_text(arm->amplitude_m, Dimension::kLength), to_text(arm->frequency_Hz, Dimension::kFrequency),
                       times(arm->from_s, arm->over_s));
  }
  if (!task.friction.empty()) {
    out += "  friction:\n";
    for (const FrictionStep& step : task.friction) {
      out += fmt::format("    - {{at: {}, to: {}}}\n", to_text(step.from_s, Dimension::kTime),
                         to_text(step.friction, Dimension::kNone));
    }
  }
  if (!task.phases.empty()) out += "  phases:\n";
  for (const Phase& phase : task.phases) out += phase_text(phase);
  if (task.lost_m) out += fmt::format("  lost: {}\n", to_text(*task.lost_m, Dimension::kLength));
  return out.empty() ? "" : "task:\n" + out;
}

}  // namespace thenar
