// SPDX-License-Identifier: Apache-2.0
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
  run_.emplace(model_);
  is_closed_ = false;
  watch_from_s_ = judged_s_ = found_s_ = 0.0;
  judged_ = {};
  warnings_.emplace(model_);
  sums_ = {};
  missed_ = 0;
}

void LiveVerdict::renew_monitor(double shift_s) {
  for (double* const since_s : {&watch_from_s_, &judged_s_, &found_s_}) *since_s += shift_s;
  monitor_.emplace(model_);
  run_.reset();  // It is another scene's.
}

void LiveVerdict::watch_anew(double time_s) {
  monitor_.emplace(model_);
  watch_from_s_ = time_s;
}

void LiveVerdict::add(TickRecord& tick, const Snapshot& after, const ControlSample& control) {
  sums_.add(tick);
  warnings_->add(tick);
  // Phases that go on without the object, or after one that failed, hold nothing.
  if (is_closed_ && !model_.scene.task.phases.empty()) return;
  for (std::optional<GraspMonitor>* const judge : {&run_, &monitor_}) {
    if (!*judge) continue;
    if (tick.contact.handed_over) {
      (*judge)->add(tick.time_s - model_.scene.step_s, control.step.control, control.muscle_forces_N);
    }
    (*judge)->add(tick, after.pull_N);
    if (is_closed_ || !(*judge)->is_closed()) continue;
    judged_ = (*judge)->verdict();
    is_closed_ = true;
    run_.reset();
    return watch_anew(tick.time_s);
  }
  if (tick.is_from(model_.scene.duration_s)) run_.reset();
  const bool watched = tick.time_s - watch_from_s_ > (is_fine(judged_.outcome) ? kWatch_s : kWatchFailed_s);
  if (!watched && !monitor_->lost() && tick.time_s - judged_s_ < kJudge_s) return;
  judged_s_ = tick.time_s;
  Verdict verdict = monitor_->verdict();
  const bool failed = !is_fine(verdict.outcome);
  // Of one trouble the gravest word stays; after an end, all of it.
  const bool graver = verdict.outcome >= judged_.outcome || tick.time_s - found_s_ > kWatchFailed_s;
  if (failed ? graver && !is_closed_ : watched) {
    judged_ = std::move(verdict);
    found_s_ = tick.time_s;
    is_closed_ = false;
  }
  if (failed || watched) watch_anew(tick.time_s);
}

void LiveVerdict::miss(std::int64_t lost) {
  if (lost <= missed_) return;
  const std::string what = fmt::format("the records of {} ticks were lost: nobody saw what they did", lost - missed_);
  monitor_->miss(what);
  if (run_) run_->miss(what);
  missed_ = lost;
}

}  // namespace thenar::window
