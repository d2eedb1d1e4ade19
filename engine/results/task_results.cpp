#include "engine/results/task_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace thenar {

using nlohmann::ordered_json;

namespace {

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();

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

namespace {

double grip_N(const TickRecord& tick) {
  double sum_N = 0.0;
  for (const NormalTangential& force : tick.force) sum_N += force.normal_N;
  return sum_N;
}

/// Pearson's, of grip and load.
double correlation(std::span<const TickRecord> ticks) {
  double n = 0.0, g = 0.0, l = 0.0, gg = 0.0, ll = 0.0, gl = 0.0;
  for (const TickRecord& tick : ticks) {
    const double grip = grip_N(tick), load = tick.borne_N;
    n += 1.0, g += grip, l += load, gg += grip * grip, ll += load * load, gl += grip * load;
  }
  return (n * gl - g * l) / std::sqrt((n * gg - g * g) * (n * ll - l * l));
}

/// The ticks of a phase.
std::span<const TickRecord> ticks_of(const Recording& recording, int phase) {
  const auto range = std::ranges::equal_range(recording.ticks, phase, {}, &TickRecord::phase);
  return {range.begin(), range.end()};
}

/// From the load phase on, the first tick in which nothing but the fingers bears the object.
ordered_json lift_off(const Recording& recording, std::span<const TickRecord> load) {
  constexpr double kAround_s = 10e-3;
  const TickRecord* const end = recording.ticks.data() + recording.ticks.size();
  const TickRecord* const off =
      std::find_if(load.data(), end, [](const TickRecord& tick) { return tick.contact.environment.active == 0; });
  if (off == end) return {{"at_s", kNever}, {"borne_N", kNever}, {"largest_step_um", kNever}};
  double step_m = 0.0;
  for (const TickRecord* tick = off; tick > recording.ticks.data() && tick->time_s > off->time_s - kAround_s; --tick)
    step_m = std::max(step_m, (tick->position_m - tick[-1].position_m).norm());
  for (const TickRecord* tick = off + 1; tick < end && tick->time_s < off->time_s + kAround_s; ++tick)
    step_m = std::max(step_m, (tick->position_m - tick[-1].position_m).norm());
  return {{"at_s", off->time_s}, {"borne_N", off->borne_N}, {"largest_step_um", 1e6 * step_m}};
}

}  // namespace

ordered_json task_measures(const Scene& scene, const Recording& recording) {
  ordered_json phases = ordered_json::array(), task;
  for (int i = 0; i < std::ssize(scene.task.phases); ++i) {
    const Phase::Kind kind = scene.task.phases[static_cast<std::size_t>(i)].kind;
    const std::span<const TickRecord> ticks = ticks_of(recording, i);
    const bool began = !ticks.empty(), ended = began && recording.ticks.back().phase > i;
    phases.push_back({{"phase", to_string(kind)},
                      {"from_s", began ? ticks.front().time_s : kNever},
                      {"until_s", ended ? ticks.back().time_s : kNever}});
    if (kind != Phase::Kind::kLoad || !began) continue;
    phases.back()["grip_load_correlation"] = correlation(ticks);
    if (ticks.front().contact.environment.active > 0) phases.back()["lift_off"] = lift_off(recording, ticks);
  }
  task["phases"] = phases;
  task["weight_N"] = scene.object.mass_kg * scene.gravity.norm();
  return task;
}

}  // namespace thenar
