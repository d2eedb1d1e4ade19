// SPDX-License-Identifier: Apache-2.0
#include "engine/results/task_results.h"

#include <fmt/format.h>

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// The body that bears most of what all bear together; -1: none touches.
Index strongest(const Scene& scene, const BodyForces& body_N) {
  const Vector3d sum_N = body_N.rowwise().sum();
  Index body = -1;
  if (!scene.environment || body_N.isZero(0.0)) return body;
  (sum_N.transpose() * body_N).maxCoeff(&body);
  return body;
}

std::string name_of(const Scene& scene, const BodyForces& body_N) {
  const Index body = strongest(scene, body_N);
  if (body < 0) return "something";
  return fmt::format("'{}'", scene.environment->bodies.at(static_cast<std::size_t>(body)).name);
}

/// What a phase lacks.
std::string lack_in_words(const Scene& scene, const TaskReport& task, const Phase& phase, const BodyForces& body_N) {
  const PhaseLack& lack = task.lack;
  const std::string finger =
      lack.finger >= 0 ? scene.hand.fingertips[static_cast<std::size_t>(lack.finger)].finger : std::string();
  const double way_mm = 1e3 * phase.by_m.norm(), arm_mm = 1e3 * task.arm_way_m;
  const std::string after = fmt::format("after {:.3g} of {:.3g} mm", 1e3 * task.object_way_m, way_mm);
  switch (lack.fault) {
    case PhaseFault::kNone:
      break;
    case PhaseFault::kTouchesEarly:
      return arm_mm < 0.01 ? fmt::format("the {} touches the object before the arm has gone any way", finger)
                           : fmt::format(
                                 "the {} touches the object {:.3g} mm on the arm's way, before the fingers "
                                 "close",
                                 finger, arm_mm);
    case PhaseFault::kNotThere:
      return fmt::format("the {} is still {:.3g} mm from the object", finger, 1e3 * lack.value);
    case PhaseFault::kNotPressing:
      if (lack.bound == 0.0)
        return "no contact forces within the friction cones press the object as the fingers touch it";
      return fmt::format("the {}'s force is {:.3g} N off the {:.3g} N that it is asked for", finger, lack.value,
                         lack.bound);
    case PhaseFault::kNotLoaded:
      return fmt::format("the fingers bear {:.3g} N, and the object weighs {:.3g} N", lack.value, lack.bound);
    case PhaseFault::kNotFree:
      return fmt::format("{} {}", resistance_in_words(scene, body_N), after);
    case PhaseFault::kBehind: {
      const std::string gone = fmt::format("the object stands {:.3g} mm behind the arm, {}", 1e3 * lack.value, after);
      return strongest(scene, body_N) < 0 ? gone : fmt::format("{}: {}", gone, resistance_in_words(scene, body_N));
    }
    case PhaseFault::kJammed:
      return fmt::format("{} resists with {:.4g} N {}, more than its {:.4g} N", name_of(scene, body_N), lack.value,
                         after, lack.bound);
    case PhaseFault::kNothingUnder:
      if (strongest(scene, body_N) < 0) return fmt::format("nothing bears the object after {:.3g} mm", arm_mm);
      if (!(lack.value > 0.0)) {
        return fmt::format("nothing bears the object from below after {:.3g} mm: {}", arm_mm,
                           resistance_in_words(scene, body_N));
      }
      return fmt::format("what is under the object bears {:.3g} N of its {:.3g} N after {:.3g} mm: {}", lack.value,
                         lack.bound, arm_mm, resistance_in_words(scene, body_N));
    case PhaseFault::kGaveWay:
      return fmt::format(
          "what bore the object gave way: the fingers bear {:.3g} N of its {:.3g} N, and the arm has gone "
          "all of its {:.3g} mm",
          lack.value, lack.bound, way_mm);
    case PhaseFault::kNotUnloaded:
      return fmt::format("the fingers still bear {:.3g} N of the weight that they leave to what is under the object",
                         lack.value);
    case PhaseFault::kNotOpen:
      return finger.empty() ? "the fingers are not open yet"
                            : fmt::format("the {} still presses the object with {:.3g} N", finger, lack.value);
    case PhaseFault::kArmLate:
      return fmt::format("the arm has gone {:.3g} of {:.3g} mm", arm_mm, way_mm);
  }
  return "";
}

}  // namespace

std::string resistance_in_words(const Scene& scene, const BodyForces& body_N) {
  const Index body = strongest(scene, body_N);
  if (body < 0) return "something resists";
  return fmt::format("{} resists with {:.3g} N", name_of(scene, body_N), body_N.col(body).norm());
}

std::string in_words(const Scene& scene, const TaskReport& task, const BodyForces& body_N) {
  const Phase& phase = scene.task.phases.at(static_cast<std::size_t>(task.phase));
  const std::string lack = lack_in_words(scene, task, phase, body_N);
  const std::string failed = task.has_failed ? fmt::format(", failed at {:.3f} s, {:.3g} s after it began", task.at_s,
                                                           task.at_s - task.since_s)
                                             : std::string();
  return fmt::format("phase {}, {}{}{}{}", task.phase + 1, to_string(phase.kind), failed, lack.empty() ? "" : ": ",
                     lack);
}

}  // namespace thenar
