// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <stop_token>

#include "engine/control/control_period.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/loops/latest_value.h"
#include "engine/loops/live_contact.h"
#include "engine/loops/realtime.h"
#include "engine/loops/split_grasp.h"

namespace thenar {

/// The record of a tick of the contact thread.
struct ContactSample {
  ContactStep step;
  Snapshot after;                ///< State after the tick.
  std::int64_t deadline_ns = 0;  ///< Time at which the tick was due (steady clock).
  std::int64_t start_ns = 0, end_ns = 0;
  std::int64_t slipped = 0;   ///< Ticks given up just before this one.
  std::int64_t lost = 0;      ///< Records of the run lost before this one.
  bool caught_up = false;     ///< True if it started late because the one before overran.
  std::int64_t stamp_ns = 0;  ///< Stamp of the live input that acted first in this tick; 0: none.
  bool shown = false;         ///< True if a picture of it was taken.
  bool overran = false;       ///< True if it ended after the next one was due.
};

/// The record of a tick of the control thread.
struct ControlSample {
  ControlStep step;
  Eigen::VectorXd muscle_forces_N;  ///< Empty without muscles.
  std::int64_t deadline_ns = 0, start_ns = 0, end_ns = 0;
  std::int64_t slipped = 0, lost = 0;  ///< See ContactSample.
};

struct ThreadSettings {
  double duration_s = 0.0;  ///< Duration of contact ticks due, slipped ones included.
  double speed = 1.0;       ///< Simulated over wall time: factor on the rates of both loops.
  double spin_s = 50e-6;    ///< Time before its tick at which the contact thread wakes, to spin.
  bool realtime = true;     ///< Request SCHED_FIFO, locked memory, a core of its own; false: default scheduling.
  int core = -1;            ///< Core of the contact thread, one of allowed_cores(); -1: the last of them.
  const CoreSetAside* set_aside = nullptr;  ///< The core reserved by the caller; null: by the run, see run_threads.
  bool quiet = false;                       ///< Log nothing.
  OwnControl own;                           ///< Called on the control thread, for frame 0 on the calling one.
  LiveContact* live = nullptr;              ///< Live input and pictures; null: none.
  /// Called first, on the calling thread: frame 0's control tick and its muscle forces, also if nothing will run.
  std::function<void(const ControlReport&, const Eigen::VectorXd& muscle_forces_N)> on_first_control;
  /// Called on the calling thread, when both threads are set up. Without it, refusals are logged.
  std::function<void(const Scheduling& contact)> on_start;
  std::function<bool()> on_look;  ///< On the calling thread, after each check for records; false ends the run.
  std::function<bool(const ContactSample&)> on_tick;     ///< On the calling thread, in order; false ends the run.
  std::function<void(const ControlSample&)> on_control;  ///< On the calling thread, in order.
};

/// The result of a threaded run. `frames` and `snapshots` count since the grasp was made.
struct ThreadsReport {
  ControlReport first_control;  ///< Result of frame 0, which is made before the threads start.
  Scheduling contact, control;  ///< Scheduling that was granted.
  ExchangeCounts frames, snapshots;
  std::int64_t ticks = 0;                 ///< Contact ticks done.
  std::int64_t slipped = 0;               ///< Contact ticks given up: simulated time lags by as many steps.
  double longest_slip_s = 0.0;            ///< Longest wall time of contact ticks given up at once, as after a stop.
  std::int64_t overruns = 0;              ///< Contact ticks that ended after the next one was due.
  std::int64_t lost_samples = 0;          ///< Records lost as the ring was full, without on_tick.
  std::int64_t lost_control_samples = 0;  ///< Likewise, without on_control.
  double wall_s = 0.0;
};

/// The counts of a contact loop's ticks.
struct ContactLoopCounts {
  std::int64_t ticks = 0, slipped = 0;  ///< Together the ticks that were due, unless the loop was stopped.
  std::int64_t longest_slip = 0;        ///< Largest number of ticks given up at once.
  std::int64_t overruns = 0;            ///< Ticks that ended after the next one was due.
  std::int64_t lost_samples = 0;        ///< Records for which there was no room.
};

/// Runs the contact thread's loop: waits for each tick of the schedule, runs it, and passes its record to `keep`, which
/// returns false if there is no room. With `live` it takes input from there, and leaves pictures. It does not allocate,
/// lock, log, throw or call the system except to sleep, nor may `keep`.
ContactLoopCounts run_contact_loop(SplitGrasp& grasp, Schedule schedule, std::int64_t spin_ns,
                                   const std::function<bool(const ContactSample&)>& keep, const std::stop_token& stop,
                                   LiveContact* live = nullptr) noexcept;

/// Runs a scene in real time on two threads, contact at 1 / step and control at 1 / control period, while the calling
/// thread receives their records. With `realtime`, and two cores or more, one core is reserved for the contact thread:
/// until the run ends the calling thread, and threads it starts, use the others. With a single core control runs
/// without a real-time priority: two such threads would take all its time, and the kernel then stops both. `state`: in,
/// the start; out, the end of the run. Without grasp forces for the start nothing runs. Unless `quiet`, refusals and
/// faults are logged, at most once a second. While a function of `settings.own` is slow, the last frame stays in use
/// and is then held. Its exceptions end the run, and are rethrown here.
ThreadsReport run_threads(const Model& model, State& state, const ThreadSettings& settings);

/// Runs an existing grasp, which may continue in another run: its state, its controller's memory and its last frame are
/// kept. on_first_control is not called.
ThreadsReport run_threads(SplitGrasp& grasp, const ThreadSettings& settings);

}  // namespace thenar
