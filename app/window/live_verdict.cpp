#include "app/window/live_verdict.h"

#include <fmt/format.h>

#include <utility>

namespace thenar::window {

namespace {

// A monitor sums up slip. In a run without end it begins again from time to time, so that years of creep do not count
// as a loss; and soon after something went wrong, to tell when the object is held again.
constexpr double kWatch_s = 10.0, kWatchFailed_s = 3.0;
constexpr double kJudge_s = 0.1;  // Simulated time from one verdict to the next.

}  // namespace

void LiveVerdict::reset() {
  monitor_.emplace(model_);
  watch_from_s_ = judged_s_ = found_s_ = 0.0;
  judged_ = {};
  warnings_.emplace(model_);
  sums_ = {};
  missed_ = 0;
}

void LiveVerdict::renew_monitor(double shift_s) {
  for (double* const since_s : {&watch_from_s_, &judged_s_, &found_s_}) *since_s += shift_s;
  monitor_.emplace(model_);
}

void LiveVerdict::add(TickRecord& tick, const Snapshot& after, const ControlSample& control) {
  sums_.add(tick);
  if (tick.contact.handed_over) {
    monitor_->add(tick.time_s - model_.scene.step_s, control.step.control, control.muscle_forces_N);
  }
  warnings_->add(tick);
  monitor_->add(tick, after.pull_N);
  const bool watched = tick.time_s - watch_from_s_ > (is_fine(judged_.outcome) ? kWatch_s : kWatchFailed_s);
  if (!watched && !monitor_->lost() && tick.time_s - judged_s_ < kJudge_s) return;
  judged_s_ = tick.time_s;
  Verdict verdict = monitor_->verdict();
  const bool failed = !is_fine(verdict.outcome);
  // Of one trouble the gravest word stays.
  const bool graver = verdict.outcome >= judged_.outcome || tick.time_s - found_s_ > kWatchFailed_s;
  if (failed ? graver : watched) {
    judged_ = std::move(verdict);
    found_s_ = tick.time_s;
  }
  if (!failed && !watched) return;
  monitor_.emplace(model_);
  watch_from_s_ = tick.time_s;
}

void LiveVerdict::miss(std::int64_t lost) {
  if (lost <= missed_) return;
  monitor_->miss(fmt::format("the records of {} ticks were lost: nobody saw what they did", lost - missed_));
  missed_ = lost;
}

}  // namespace thenar::window
