// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/threads.h"

#include <fmt/format.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <latch>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "engine/formats/text.h"
#include "engine/loops/records.h"

namespace thenar {

namespace {

using std::chrono::milliseconds;

// Records of two seconds, for which the calling thread may be away, or off its core.
constexpr double kRoom_s = 2.0;
// Lower bound of a tick's time for any step.
constexpr double kShortestTick_s = 5e-6;
// Period in which the calling thread checks for records.
constexpr milliseconds kDrainPeriod{3};
// From the end of the threads' set-up to the first tick: both are asleep by then.
constexpr std::int64_t kStartDelay_ns = 5'000'000;
constexpr int kMaxCatchUp = 2;
// Control priority, below the contact thread's. Beside three programs that kept its core busy, a control thread at 1
// kHz without it was late, and its drive held, 4 to 7 times a second.
constexpr int kControlPriority = 70;
// Share of an overloaded thread's busy time: twice the rest that keeps the kernel from stopping it.
constexpr double kRestShare = 0.1;
constexpr std::int64_t kSecond_ns = 1'000'000'000;
// Ticks given up at once for longer than this are no overrun: the process was stopped, or its machine.
constexpr double kStandstill_s = 0.5;
// A more distant tick is waited for in parts, so that a stop need not wait for it.
constexpr std::int64_t kPatience_ns = 20'000'000;

/// Returns the room for records of this period in a run of this length.
std::size_t room_for_records(double period_s, double duration_s) {
  return static_cast<std::size_t>(std::ceil(std::min(kRoom_s, duration_s) / std::max(period_s, kShortestTick_s))) + 16;
}

/// A log for the operator of a long run, on stderr unless the program has its own logger "thenar".
class RunLog {
 public:
  RunLog(bool quiet, double step_s) : step_s_(step_s) {
    if (quiet) return;
    log_ = spdlog::get("thenar");
    if (!log_) log_ = spdlog::stderr_color_mt("thenar");
  }

  void started(const Scheduling& contact) {
    if (log_ && !contact.remark.empty()) log_->warn("{}", contact.remark);
  }

  void add(const ContactSample& sample) {
    slipped_ += sample.slipped;
    longest_slip_ = std::max(longest_slip_, sample.slipped);
    overruns_ += sample.overran;
    count_lost(sample.lost, contact_lost_);
    if (sample.step.tick.held != held_) {
      held_ = sample.step.tick.held;
      ++(held_ ? holds_ : releases_);
    }
    note(sample.end_ns);
  }

  void add(const ControlSample& sample) {
    if (!sample.step.published) ++refused_;
    count_lost(sample.lost, control_lost_);
    note(sample.end_ns);
  }

  /// Reports faults since the last report: at most once a second, and ever more rarely, to once a minute.
  void say_if_due(std::int64_t now_ns) {
    if (now_ns < next_ns_ || !say(now_ns)) return;
    next_ns_ = now_ns + pause_ns_;
    pause_ns_ = std::min(2 * pause_ns_, 60 * kSecond_ns);
  }

  /// Reports now; false if there is nothing to report.
  bool say(std::int64_t now_ns) {
    if (!log_ || nothing()) return false;
    std::string what;
    const auto add_clause = [&what](const std::string& clause) { what += (what.empty() ? "" : "; ") + clause; };
    if (overruns_ + slipped_ > 0) {
      const char* const given_up = slipped_ == 1 ? "was given up" : "were given up";
      const double longest_s = static_cast<double>(longest_slip_) * step_s_;
      add_clause(counted(overruns_, "contact tick") + " overran" +
                 (slipped_ > 0 ? fmt::format(", {} {}", slipped_, given_up) : "") +
                 (longest_s > kStandstill_s ? fmt::format(" (the run stood still for {:.1f} s)", longest_s) : ""));
    }
    if (holds_ > 0) add_clause(counted(holds_, "hold") + " began (frames came too late)");
    if (releases_ > 0) add_clause(counted(releases_, "hold") + " ended (frames came again)");
    if (refused_ > 0) add_clause(counted(refused_, "frame") + " refused (not finite)");
    if (lost_ > 0) add_clause(counted(lost_, "record") + " lost (nobody had time for them)");
    const std::int64_t seconds = std::max<std::int64_t>(1, (now_ns - since_ns_ + kSecond_ns - 1) / kSecond_ns);
    log_->warn("in the last {} {}", seconds == 1 ? "second" : counted(seconds, "second"), what);
    overruns_ = slipped_ = longest_slip_ = holds_ = releases_ = refused_ = lost_ = 0;
    since_ns_ = kNever_ns;
    return true;
  }

 private:
  static constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::max();

  [[nodiscard]] bool nothing() const { return overruns_ + slipped_ + holds_ + releases_ + refused_ + lost_ == 0; }

  /// `so_far`: total of the run; `before`: total at the thread's last record.
  void count_lost(std::int64_t so_far, std::int64_t& before) { lost_ += so_far - std::exchange(before, so_far); }

  /// Notes that the first unreported fault happened at this time, or before.
  void note(std::int64_t time_ns) {
    if (!nothing()) since_ns_ = std::min(since_ns_, time_ns);
  }

  std::shared_ptr<spdlog::logger> log_;  // Null: quiet.
  double step_s_;                        // by the clock on the wall
  bool held_ = false;
  std::int64_t contact_lost_ = 0, control_lost_ = 0;  // of the whole run
  std::int64_t overruns_ = 0, slipped_ = 0, longest_slip_ = 0, holds_ = 0, releases_ = 0, refused_ = 0, lost_ = 0;
  std::int64_t since_ns_ = kNever_ns;
  std::int64_t next_ns_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t pause_ns_ = kSecond_ns;
};

/// Waits as wait_until does, or until it is stopped.
std::int64_t wait_for_tick(std::int64_t deadline_ns, std::int64_t spin_ns, const std::stop_token& stop) noexcept {
  for (std::int64_t now_ns = steady_now_ns(); deadline_ns - now_ns > 2 * kPatience_ns;) {
    now_ns = wait_until(now_ns + kPatience_ns, 0);
    if (stop.stop_requested()) return now_ns;
  }
  return wait_until(deadline_ns, spin_ns);
}

/// Runs the control thread's loop, until it is stopped. A late tick is given up at once: a newer snapshot is better.
/// Adds the number of records lost as the ring was full to `lost`.
void run_control_loop(SplitGrasp& grasp, Schedule schedule, bool muscles, Records<ControlSample>& records,
                      std::int64_t& lost, const std::stop_token& stop) {
  ControlSample sample;
  while (const auto tick = schedule.next(steady_now_ns())) {
    sample.start_ns = wait_for_tick(tick->deadline_ns, 0, stop);
    if (stop.stop_requested()) return;
    sample.deadline_ns = tick->deadline_ns;
    sample.slipped = tick->slipped;
    sample.step = grasp.control_step();
    if (muscles) sample.muscle_forces_N = grasp.muscle_forces_N();
    sample.end_ns = steady_now_ns();
    sample.lost = lost;
    if (!records.keep(sample)) ++lost;
  }
}

/// Reports about the contact thread's core.
void remark_on(const CoreSetAside& core, Scheduling& contact) {
  if (core.number() < 0) {
    add_remark(contact, "there is one core alone: control has no real-time priority, and waits for the contact thread");
  } else if (core.taken()) {
    add_remark(contact, fmt::format("core {} is the contact thread's of another run, too: both will be late. --core "
                                    "chooses another one",
                                    core.number()));
  }
}

/// Returns the begin of the run, once that is known; 0 if it is stopped before.
std::int64_t wait_for_start(const std::atomic<std::int64_t>& start_ns, const std::stop_token& stop) {
  // Relaxed: the number is all that is passed.
  while (start_ns.load(std::memory_order_relaxed) == 0 && !stop.stop_requested()) {
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  return start_ns.load(std::memory_order_relaxed);
}

/// A run on two threads, while the calling one receives their records.
class TwoThreads {
 public:
  TwoThreads(SplitGrasp& grasp, const ThreadSettings& settings);
  ThreadsReport run();

 private:
  void contact_thread(const std::stop_token& stop);
  void control_thread(const std::stop_token& stop);
  void start();
  void receive();

  [[nodiscard]] const CoreSetAside& core() const {
    return settings_.set_aside != nullptr ? *settings_.set_aside : *own_;
  }

  SplitGrasp& grasp_;
  const ThreadSettings& settings_;
  double step_s_, control_period_s_;  // by the clock on the wall
  double spin_s_;
  ThreadsReport report_;
  Records<ContactSample> contact_records_;
  Records<ControlSample> control_records_;
  RunLog log_;
  std::optional<CoreSetAside> own_;
  std::optional<AwakeCores> awake_;
  bool has_frame_;  ///< Of the state as it is: frame 0 is such a one.
  bool goes_on_ = true;
  ContactLoopCounts counts_;
  std::exception_ptr failure_, contact_failure_;  // of the control thread, of the contact thread before it runs
  std::latch set_up_{2};
  std::atomic<std::int64_t> start_ns_{0};
  // Relaxed: what the threads leave is read when they are joined.
  std::atomic<int> running_{2};
};

TwoThreads::TwoThreads(SplitGrasp& grasp, const ThreadSettings& settings)
    : grasp_(grasp),
      settings_(settings),
      step_s_(grasp.model().scene.step_s / settings.speed),
      control_period_s_(grasp.model().scene.control_period_s / settings.speed),
      spin_s_(std::min(settings.spin_s, 0.5 * step_s_)),  // At most half a step is spun away.
      contact_records_(room_for_records(step_s_, settings.duration_s / settings.speed), {{}, grasp.state()}),
      control_records_(room_for_records(control_period_s_, settings.duration_s / settings.speed), {}),
      log_(settings.quiet, step_s_),
      has_frame_(grasp.controller().last_tick == grasp.state().tick) {
  report_.first_control = grasp.first_control();
  widen_thread_stacks();
  own_.emplace(settings.realtime && settings.set_aside == nullptr, settings.core);
  if (settings.realtime) awake_.emplace();
}

void TwoThreads::control_thread(const std::stop_token& stop) {
  try {
    const int priority = core().number() < 0 ? 0 : kControlPriority;
    report_.control = settings_.realtime ? ask_for_realtime(-1, priority) : current_scheduling();
  } catch (...) {
    failure_ = std::current_exception();
  }
  set_up_.count_down();
  const std::int64_t start = wait_for_start(start_ns_, stop);
  try {
    const std::int64_t first = start + (has_frame_ ? Schedule::nanoseconds(control_period_s_) : 0);
    run_control_loop(grasp_,
                     Schedule(first, control_period_s_, std::numeric_limits<std::int64_t>::max(), 0, kRestShare),
                     grasp_.model().scene.has_muscles(), control_records_, report_.lost_control_samples, stop);
  } catch (...) {
    failure_ = std::current_exception();
  }
  running_.fetch_sub(1, std::memory_order_relaxed);
}

void TwoThreads::contact_thread(const std::stop_token& stop) {
  try {
    report_.contact = settings_.realtime ? ask_for_realtime(core().number()) : current_scheduling();
  } catch (...) {
    contact_failure_ = std::current_exception();
  }
  report_.contact.denormals_flushed = flush_denormals();
  report_.contact.spin_us = 1e6 * spin_s_;
  report_.contact.kept_awake = awake_ && awake_->granted();
  set_up_.count_down();
  const std::int64_t start = wait_for_start(start_ns_, stop);
  const auto due = static_cast<std::int64_t>(std::ceil(settings_.duration_s / grasp_.model().scene.step_s - 1e-9));
  counts_ = run_contact_loop(
      grasp_, Schedule(start, step_s_, due, kMaxCatchUp, kRestShare), std::llround(1e9 * spin_s_),
      [this](const ContactSample& sample) { return contact_records_.keep(sample); }, stop, settings_.live);
  running_.fetch_sub(1, std::memory_order_relaxed);
}

void TwoThreads::start() {
  set_up_.wait();
  for (const std::exception_ptr& refused : {failure_, contact_failure_}) {
    if (refused) std::rethrow_exception(refused);
  }
  if (settings_.realtime) remark_on(core(), report_.contact);
  if (settings_.on_start) {
    settings_.on_start(report_.contact);
  } else {
    log_.started(report_.contact);
  }
  start_ns_.store(steady_now_ns() + kStartDelay_ns, std::memory_order_relaxed);
}

void TwoThreads::receive() {
  contact_records_.drain([&](const ContactSample& sample) {
    log_.add(sample);
    if (goes_on_ && settings_.on_tick) goes_on_ = settings_.on_tick(sample);
  });
  control_records_.drain([&](const ControlSample& sample) {
    log_.add(sample);
    if (settings_.on_control) settings_.on_control(sample);
  });
  log_.say_if_due(steady_now_ns());
}

ThreadsReport TwoThreads::run() {
  // A jthread that goes out of scope is stopped and joined: also when this function is left by an exception.
  std::jthread control([this](const std::stop_token& stop) { control_thread(stop); });
  std::jthread contact([this](const std::stop_token& stop) { contact_thread(stop); });
  start();
  // One thread has ended by itself only if the run is over, or the control failed.
  while (goes_on_ && running_.load(std::memory_order_relaxed) == 2) {
    receive();
    if (settings_.on_look && !settings_.on_look()) break;
    std::this_thread::sleep_for(kDrainPeriod);
  }
  contact.request_stop();
  contact.join();
  control.request_stop();
  control.join();
  report_.wall_s = 1e-9 * static_cast<double>(steady_now_ns() - start_ns_.load(std::memory_order_relaxed));
  receive();
  log_.say(steady_now_ns());
  if (failure_) std::rethrow_exception(failure_);

  report_.frames = grasp_.frames().counts();
  report_.snapshots = grasp_.snapshots().counts();
  report_.ticks = counts_.ticks;
  report_.slipped = counts_.slipped;
  report_.longest_slip_s = static_cast<double>(counts_.longest_slip) * step_s_;
  report_.overruns = counts_.overruns;
  report_.lost_samples = counts_.lost_samples;
  return report_;
}

}  // namespace

ContactLoopCounts run_contact_loop(SplitGrasp& grasp, Schedule schedule, std::int64_t spin_ns,
                                   const std::function<bool(const ContactSample&)>& keep, const std::stop_token& stop,
                                   LiveContact* live) noexcept {
  ContactLoopCounts counts;
  ContactSample sample;
  sample.end_ns = steady_now_ns();
  while (const auto tick = schedule.next(sample.end_ns)) {
    sample.deadline_ns = tick->deadline_ns;
    sample.slipped = tick->slipped;
    sample.caught_up = tick->caught_up;
    sample.start_ns = wait_for_tick(tick->deadline_ns, spin_ns, stop);
    if (stop.stop_requested()) break;
    if (live == nullptr) {
      sample.step = grasp.contact_step();
    } else {
      sample.step = grasp.contact_step(live->input(grasp.state(), sample.start_ns, sample.stamp_ns));
      sample.shown = live->show(grasp);
    }
    sample.end_ns = steady_now_ns();
    sample.overran = sample.end_ns > schedule.next_deadline_ns();
    counts.overruns += sample.overran;
    ++counts.ticks;
    sample.after = grasp.state();
    sample.lost = counts.lost_samples;
    if (!keep(sample)) ++counts.lost_samples;
  }
  counts.slipped = schedule.slipped();
  counts.longest_slip = schedule.longest_slip();
  return counts;
}

ThreadsReport run_threads(const Model& model, State& state, const ThreadSettings& settings) {
  SplitGrasp grasp(model, state, settings.own);
  if (settings.on_first_control) settings.on_first_control(grasp.first_control(), grasp.muscle_forces_N());
  if (grasp.first_control().grasp != GraspStatus::kOptimal) {
    ThreadsReport report;
    report.first_control = grasp.first_control();
    return report;
  }
  const ThreadsReport report = run_threads(grasp, settings);
  state = grasp.state();
  return report;
}

ThreadsReport run_threads(SplitGrasp& grasp, const ThreadSettings& settings) {
  return TwoThreads(grasp, settings).run();
}

}  // namespace thenar
