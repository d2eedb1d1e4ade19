// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>

#include "engine/control/control_tick.h"
#include "engine/grasp/contact_tick.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/loops/run.h"
#include "engine/results/grasp_monitor.h"
#include "engine/results/recording.h"

namespace thenar {

/// Returns the record of a tick from the state after it, what it reported, and the control tick whose frame it used.
[[nodiscard]] TickRecord tick_record(const Model& model, const Snapshot& after, const TickReport& contact,
                                     const ControlReport& control);

/// Writes into the record what a control tick before this one cost and found.
void record_control(const ControlReport& control, TickRecord& record);

/// Returns in words: "the run was interrupted at 0.412 s".
[[nodiscard]] std::string interruption(double time_s);

/// Sums up over a run what its ticks report, tick by tick, however small, and remembers the last reflex and stiffness.
class RunSums {
 public:
  /// Takes the next tick, and writes the sums so far into it.
  void add(TickRecord& tick);

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(slip_m_, spin_rad_, start_slip_m_, start_spin_rad_, walk_m_, turn_rad_, ledger_, last_reflex_, stiffness_);
  }

 private:
  // Of a tick's fingers, from the first one on.
  PerFinger<double> slip_m_, spin_rad_, start_slip_m_, start_spin_rad_;
  PerFinger<Eigen::Vector3d> walk_m_;
  PerFinger<double> turn_rad_;
  Ledger ledger_;
  LastReflex last_reflex_;
  KnownStiffness stiffness_;
};

/// Makes the record of a tick that a watcher sees, with the sums so far: each tick of the run in its order.
[[nodiscard]] TickRecord tick_record(const Model& model, const Tick& tick, RunSums& sums);

/// Gathers a run tick by tick, and watches it.
class Recorder : public Watcher {
 public:
  explicit Recorder(const Model& model);

  /// Returns false without a first solution: there are no forces to go on with.
  bool see_control(const ControlTick& tick) override;
  /// Returns false if the run is to end: a controller has lost its object.
  bool see_tick(const Tick& tick) override;
  /// Notes that records were lost, as `what` says.
  void miss(const std::string& what) { monitor_.miss(what); }
  /// Notes that the run was ended from outside: its outcome is unknown.
  void interrupt(double time_s) {
    monitor_.miss(interruption(time_s));
    interrupted_ = true;
  }
  /// Ends and judges the run as the state and the last control tick left it.
  [[nodiscard]] Recording finish(const Snapshot& state, const ControlReport& control, double wall_s);
  /// Returns the number of ticks of the whole scene.
  [[nodiscard]] std::int64_t planned() const { return planned_; }

 private:
  /// For the whole scene, with the first tick: in real time memory that is there when the threads start is fetched and
  /// locked whole, what comes later as it is touched.
  void make_room();

  const Model& model_;
  std::int64_t planned_;
  Recording recording_;
  RunSums sums_;
  GraspMonitor monitor_;
  bool interrupted_ = false;
};

}  // namespace thenar
