#include "engine/results/task_results.h"

#include <fmt/format.h>

namespace thenar {

namespace {

/// What came about instead of the phase's end.
std::string cause(const Scene& scene, const TaskReport& task, const Phase& phase) {
  const std::string finger =
      task.finger >= 0 ? scene.hand.fingertips[static_cast<std::size_t>(task.finger)].finger : std::string();
  const double way_mm = 1e3 * phase.by_m.norm(), done_mm = 1e3 * task.way_m;
  switch (task.fault) {
    case PhaseFault::kNone:
      break;
    case PhaseFault::kTouchesEarly:
      return done_mm < 0.01
                 ? fmt::format("the {} touches the object before the arm has gone any way", finger)
                 : fmt::format("the {} touches the object {:.3g} mm on the arm's way, before the fingers close", finger,
                               done_mm);
    case PhaseFault::kNotThere:
      return fmt::format("the {} is still {:.3g} mm from the object", finger, 1e3 * task.value);
    case PhaseFault::kNotPressing:
      return fmt::format("the {}'s force is {:.3g} N off the {:.3g} N that it is asked for", finger, task.value,
                         task.bound);
    case PhaseFault::kNotLoaded:
      return fmt::format("the fingers bear {:.3g} N, and the object weighs {:.3g} N", task.value, task.bound);
    case PhaseFault::kNotFree:
      return fmt::format("the fingers bear {:.3g} N where nothing else should bear the object, which weighs {:.3g} N",
                         task.value, task.bound);
    case PhaseFault::kJammed:
      return fmt::format("{:.4g} N resist after {:.3g} of {:.3g} mm, more than its {:.4g} N", task.value, done_mm,
                         way_mm, task.bound);
    case PhaseFault::kNothingUnder:
      return fmt::format("what is under the object bears {:.3g} N of its {:.3g} N after {:.3g} mm", task.value,
                         task.bound, done_mm);
    case PhaseFault::kNotUnloaded:
      return fmt::format("the fingers still bear {:.3g} N of the weight that they leave to what is under the object",
                         task.value);
    case PhaseFault::kNotOpen:
      return finger.empty() ? "the fingers are not open yet"
                            : fmt::format("the {} still presses the object with {:.3g} N", finger, task.value);
    case PhaseFault::kArmLate:
      return fmt::format("the arm has gone {:.3g} of {:.3g} mm", done_mm, way_mm);
  }
  return "";
}

}  // namespace

std::string in_words(const Scene& scene, const TaskReport& task) {
  const Phase& phase = scene.task.phases.at(static_cast<std::size_t>(task.phase));
  return fmt::format("phase {}, {}, failed at {:.3f} s, {:.3g} s after it began: {}", task.phase + 1,
                     to_string(phase.kind), task.failed_s, task.failed_s - task.since_s, cause(scene, task, phase));
}

}  // namespace thenar
