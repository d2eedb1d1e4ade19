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

/// What leaves the contact thread for each of its ticks.
struct ContactSample {
  ContactStep step;
  Snapshot after;                ///< The state that the tick left.
  std::int64_t deadline_ns = 0;  ///< When the tick was due (steady clock).
  std::int64_t start_ns = 0, end_ns = 0;
  std::int64_t slipped = 0;   ///< Ticks given up just before this one.
  std::int64_t lost = 0;      ///< Records of the run before this one that found no room.
  bool caught_up = false;     ///< It started late because the one before overran.
  std::int64_t stamp_ns = 0;  ///< Of the live input that acted in this tick for the first time; 0: of none.
  bool shown = false;         ///< A picture of it was taken.
  bool overran = false;       ///< It ended after the next one was due.
};

/// What leaves the control thread for each of its ticks.
struct ControlSample {
  ControlStep step;
  Eigen::VectorXd muscle_forces_N;  ///< Empty without muscles.
  std::int64_t deadline_ns = 0, start_ns = 0, end_ns = 0;
  std::int64_t slipped = 0, lost = 0;  ///< As a contact tick's.
};

struct ThreadSettings {
  double duration_s = 0.0;  ///< Of contact ticks due, slipped ones included.
  double speed = 1.0;       ///< Simulated over wall time: both loops' ticks are so many times rarer, or more frequent.
  double spin_s = 50e-6;    ///< The contact thread wakes so long before its tick is due, and spins.
  bool realtime = true;     ///< Ask for SCHED_FIFO, locked memory, a core of its own. False: take what any thread gets.
  int core = -1;            ///< The contact thread's, one of allowed_cores(); -1: the last of them.
  const CoreSetAside* set_aside = nullptr;  ///< The caller has set it aside; null: the run does, see run_threads.
  bool quiet = false;                       ///< Log nothing.
  OwnControl own;                           ///< Called on the control thread, for frame 0 on the calling one.
  LiveContact* live = nullptr;              ///< Live input and pictures; null: none.
  /// On the calling thread, before all else: frame 0's control tick and its muscle forces, also if nothing will run.
  std::function<void(const ControlReport&, const Eigen::VectorXd& muscle_forces_N)> on_first_control;
  /// On the calling thread, when both threads are set up. Without it, what was refused is logged.
  std::function<void(const Scheduling& contact)> on_start;
  std::function<bool()> on_look;  ///< On the calling thread, whenever it has looked for records; false ends the run.
  std::function<bool(const ContactSample&)> on_tick;     ///< On the calling thread, in order; false ends the run.
  std::function<void(const ControlSample&)> on_control;  ///< On the calling thread, in order.
};

/// What is known when a threaded run has ended. `frames` and `snapshots` are those of the grasp since it was made.
struct ThreadsReport {
  ControlReport first_control;  ///< Of frame 0, which is made before the threads start.
  Scheduling contact, control;  ///< What was granted.
  ExchangeCounts frames, snapshots;
  std::int64_t ticks = 0;                 ///< Contact ticks done.
  std::int64_t slipped = 0;               ///< Contact ticks given up: simulated time lags by so many steps.
  double longest_slip_s = 0.0;            ///< The longest wall time of contact ticks given up at once, as after a stop.
  std::int64_t overruns = 0;              ///< Contact ticks that ended after the next one was due.
  std::int64_t lost_samples = 0;          ///< Records that found the ring full: on_tick was not called for them,
  std::int64_t lost_control_samples = 0;  ///< or on_control.
  double wall_s = 0.0;
};

/// What became of the ticks of a contact loop.
struct ContactLoopCounts {
  std::int64_t ticks = 0, slipped = 0;  ///< Together the ticks that were due, unless the loop was stopped.
  std::int64_t longest_slip = 0;        ///< The most ticks given up at once.
  std::int64_t overruns = 0;            ///< Ticks that ended after the next one was due.
  std::int64_t lost_samples = 0;        ///< Records that nobody had room for.
};

/// The contact thread's loop: waits for each tick of the schedule, does it, and hands its record to `keep`, which says
/// whether it had room. With `live` it takes input from there, and leaves pictures. It does not allocate, lock, log,
/// throw or call the system but to sleep, nor may `keep`.
ContactLoopCounts run_contact_loop(SplitGrasp& grasp, Schedule schedule, std::int64_t spin_ns,
                                   const std::function<bool(const ContactSample&)>& keep, const std::stop_token& stop,
                                   LiveContact* live = nullptr) noexcept;

/// Runs a scene in real time on two threads, contact at 1 / step and control at 1 / control period, while the calling
/// thread receives their records. With `realtime`, and two cores or more, one core is the contact thread's alone: until
/// the run ends the calling thread, and what it starts, keeps to the others. Where there is one alone, control runs
/// without a real-time priority: two such threads on it would take all its time, and the kernel then stops both.
/// `state`: in, where to start; out, as the run ended. Without grasp forces for the start nothing runs. Unless `quiet`,
/// what was refused and what went wrong is logged, at most once a second. While a function of `settings.own` takes its
/// time, the last frame stays in use and is then held. What it throws ends the run, and is thrown here.
ThreadsReport run_threads(const Model& model, State& state, const ThreadSettings& settings);

/// The same with a grasp that is there already, and may go on in another run: its state, its controller's memory and
/// its last frame stay as they are. on_first_control is not called.
ThreadsReport run_threads(SplitGrasp& grasp, const ThreadSettings& settings);

}  // namespace thenar
