#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "engine/loops/threads.h"
#include "engine/recordings/state_message.h"
#include "engine/results/recording.h"

namespace thenar::window {

/// What the two loops do, for eyes: over the last second on the wall's clock, and since it was made.
class Telemetry {
 public:
  /// A run begins, with such steps: rates and times are its own, counts and ledger go on.
  void begin_run(double step_s);
  void add(const thenar::ContactSample& sample);
  void add(const thenar::ControlSample& sample);
  /// The run has ended.
  void end_run(const thenar::ThreadsReport& report);

  /// Records of ticks of both loops that came not here, since it was made.
  [[nodiscard]] std::int64_t lost() const { return lost_ + contact_lost_ + control_lost_; }
  /// What others have found. The figures know nothing of it by themselves.
  void set_unaccounted(std::int64_t values) { figures_.unaccounted = static_cast<double>(values); }
  void set_reference(double error, double residual);

  /// At most four times a second it takes stock anew.
  [[nodiscard]] const thenar::LoopFigures& figures(std::int64_t now_ns);
  /// The stages' medians, as of then.
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
  std::int64_t lost_ = 0;                             // in the runs before this one,
  std::int64_t contact_lost_ = 0, control_lost_ = 0;  // and in this one
  std::vector<double> latencies_s_;                   // the last ones, in a ring
  std::int64_t latencies_ = 0;                        // how many there have been
  bool latencies_counted_ = true;
  thenar::LoopFigures figures_;
  thenar::TickRecord medians_;
};

}  // namespace thenar::window
