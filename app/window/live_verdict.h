// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/loops/threads.h"
#include "engine/results/grasp_monitor.h"
#include "engine/results/recorder.h"
#include "engine/results/verdict.h"
#include "engine/results/warnings.h"

namespace thenar::window {

/// Judges a grasp that runs without end. The model is referred to: after each change of it renew() or reset() is due.
///
/// An object that is lost, or a task that has failed, has the words of a run that ends there: within the time of the
/// scene those of `thenar run`. They stay until the hand holds the object again, and in a task in phases until reset().
class LiveVerdict {
 public:
  explicit LiveVerdict(const Model& model) : model_(model) { reset(); }

  /// Begins the grasp again, at time 0.
  void reset();
  /// Follow a change of the model. Where its steps change, the grasp goes on `shift_s` later on the simulated clock.
  void renew_warnings() { warnings_.emplace(model_); }
  void renew_monitor(double shift_s);

  /// Adds a tick with the control tick of its frame; writes the sums so far into it.
  void add(TickRecord& tick, const Snapshot& after, const ControlSample& control);
  /// Sets the number of lost records of ticks, of all runs together.
  void miss(std::int64_t lost);

  /// Returns the last verdict that was not held, until a whole watch has found nothing.
  [[nodiscard]] const Verdict& verdict() const { return judged_; }
  [[nodiscard]] std::vector<std::string> warnings() const { return warnings_->sentences(); }

 private:
  void watch_anew(double time_s);

  const Model& model_;
  std::optional<GraspMonitor> monitor_;  ///< Judge of a watch.
  std::optional<GraspMonitor> run_;      ///< Judge of all since the start, within the time of the scene.
  bool is_closed_ = false;               ///< One of them has seen the end, and nothing is held again.
  double watch_from_s_ = 0.0, judged_s_ = 0.0, found_s_ = 0.0;
  Verdict judged_;
  std::optional<Warnings> warnings_;
  RunSums sums_;             ///< Sums of all ticks; the monitor begins again.
  std::int64_t missed_ = 0;  ///< Lost records that the monitor knows of.
};

}  // namespace thenar::window
