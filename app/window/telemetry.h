// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "engine/loops/threads.h"
#include "engine/recordings/state_message.h"
#include "engine/results/recording.h"

namespace thenar::window {

/// Figures of the two loops for display: over the last second on the wall clock, and since its making.
class Telemetry {
 public:
  /// Begins a run with these steps: rates and times are its own, counts and ledger go on.
  void begin_run(double step_s);
  void add(const thenar::ContactSample& sample);
  void add(const thenar::ControlSample& sample);
  /// Ends the run.
  void end_run(const thenar::ThreadsReport& report);

  /// Returns the lost records of ticks of both loops, since its making.
  [[nodiscard]] std::int64_t lost() const { return lost_ + contact_lost_ + control_lost_; }
  /// Set figures from elsewhere, which the ticks do not contain.
  void set_unaccounted(std::int64_t values) { figures_.unaccounted = static_cast<double>(values); }
  void set_reference(double error, double residual);

  /// Returns the figures, renewed at most four times a second.
  [[nodiscard]] const thenar::LoopFigures& figures(std::int64_t now_ns);
  /// Writes the stages' medians, as of the last renewal.
  void write_stages(thenar::TickRecord& tick) const;

 private:
  struct Contact {
    std::int64_t start_ns, tick;
    double compute_us, jitter_us, assemble_s, solve_s, deform_s;
  };
  struct Control {
    std::int64_t start_ns;
    double total_us, jitter_us, find_s, factors_s, grasp_s, muscle_s;
  };
  void add_latency(double latency_s);
  void take_stock();

  double step_s_ = 0.0;
  std::deque<Contact> contact_;  // of the last second
  std::deque<Control> control_;
  std::int64_t stock_ns_ = 0;  // when it was taken
  std::int64_t overruns_ = 0, slipped_ = 0, control_slipped_ = 0;
  std::int64_t lost_ = 0;                             // in the runs before this one
  std::int64_t contact_lost_ = 0, control_lost_ = 0;  // in this run
  std::vector<double> latencies_s_;                   // the last ones, in a ring
  std::int64_t latencies_ = 0;                        // number so far
  bool latencies_counted_ = true;
  thenar::LoopFigures figures_;
  thenar::TickRecord medians_;
};

}  // namespace thenar::window
