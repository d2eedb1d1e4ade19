// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "engine/grasp/model.h"
#include "engine/loops/threads.h"
#include "engine/results/recording.h"

namespace thenar {

/// Profile entry of one contact tick.
struct ContactTrace {
  std::int64_t deadline_ns = 0, start_ns = 0, end_ns = 0;  ///< Steady clock.
  std::int64_t tick = 0;                                   ///< Steps taken after it.
  std::int64_t sequence = -1;                              ///< Sequence of the frame used.
  std::int32_t frame_age = 0;                              ///< Steps.
  std::int32_t acquire_ns = 0, publish_ns = 0;
  std::int32_t sweeps = 0, contacts = 0;
  float residual = 0.0F;
  float force_step_N = 0.0F;  ///< max over the fingers of |F_k(t) - F_k(t - 1)|; NaN if the tick before is unknown.
  PerFinger<float> force_N;   ///< |F_k|.
  bool handed_over = false, held = false, caught_up = false, finite = true;

  [[nodiscard]] double jitter_us() const { return 1e-3 * static_cast<double>(start_ns - deadline_ns); }
  [[nodiscard]] double compute_us() const { return 1e-3 * static_cast<double>(end_ns - start_ns); }
};

/// Profile entry of one control tick.
struct ControlTrace {
  std::int64_t deadline_ns = 0, start_ns = 0, end_ns = 0;
  std::int64_t sequence = 0, snapshot_tick = 0;
  float find_us = 0.0F, factors_us = 0.0F, grasp_us = 0.0F, muscle_us = 0.0F;
  bool published = false, grasp_found = true, muscles_found = true, stiffness_answered = true;

  [[nodiscard]] double jitter_us() const { return 1e-3 * static_cast<double>(start_ns - deadline_ns); }
  [[nodiscard]] double total_us() const { return 1e-3 * static_cast<double>(end_ns - start_ns); }
};

/// The ticks of a threaded run, as its latency profile needs them. It receives what run_threads gives to on_tick and
/// on_control, on the thread that called it.
class LoopProfile {
 public:
  void add(const ContactSample& sample);
  void add(const ControlSample& sample);

  [[nodiscard]] const std::deque<ContactTrace>& contact() const { return contact_; }
  [[nodiscard]] const std::deque<ControlTrace>& control() const { return control_; }
  [[nodiscard]] std::int64_t control_slipped() const { return control_slipped_; }

 private:
  std::deque<ContactTrace> contact_;  // In chunks: they grow without a pause, and take no more than there is.
  std::deque<ControlTrace> control_;
  Snapshot last_;  ///< Snapshot after the contact tick before.
  std::int64_t control_slipped_ = 0;
};

/// A run on two threads that has ended.
struct RealtimeRun {
  Recording recording;
  ThreadsReport report;
  LoopProfile profile;
};

/// The measures of a run on two threads, as its summary.json has them: those of summarize(), the largest position error
/// of the object and the ratio of the ledger's injected and dissipated energy, and the latency profile: units in the
/// keys, null where there was nothing to measure. Percentiles are those of percentiles.h, over all ticks of the run
/// unless a line below says otherwise.
///
/// jitter        Start of a tick minus its deadline, catch-up ticks included.
/// compute       Start to end of a contact tick: frame taken, step done, snapshot published.
/// rate_hz       Ticks done in the wall time between the first and the last start.
/// residual_above_1e-2, not_finite
///               Contact ticks with contacts and a larger residual (natural map), and those without a finite solution.
/// exchange      Counts of the frames, and the two costs on the contact thread: acquire, over the ticks that took a new
///               frame, and publish of the snapshot, over all ticks. Each holds one reading of the clock.
/// frame_age     Simulated time from the frame's snapshot to the tick's start.
/// handover      Force step of a tick: max over the fingers of |F_k(t) - F_k(t - 1)|. kick_N_max and kick_N_p99 at the
///               hand-overs, tick_N_p99 at all other ticks, all from 0.3 s on.
/// hold          Ticks that held an old frame's drive, and the times that this began or ended.
[[nodiscard]] nlohmann::ordered_json summarize(const Model& model, const RealtimeRun& run);
/// Adds what the two loops did to the measures of the run's recording, which makes it the same.
void add_loops(const Model& model, const RealtimeRun& run, nlohmann::ordered_json& summary);

/// Returns a sentence that records were lost; nothing if none was.
[[nodiscard]] std::optional<std::string> lost_records(const ThreadsReport& report);

}  // namespace thenar
