#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace thenar {

/// What the system granted a thread.
struct Scheduling {
  std::string policy = "SCHED_OTHER";  ///< Or "SCHED_FIFO".
  int priority = 0;
  int core = -1;  ///< The one it is pinned to; -1: any.
  bool memory_locked = false;
  bool kept_awake = false;  ///< No core of the machine sleeps so deeply that it is late.
  bool denormals_flushed = false;
  double timer_slack_ns = 0.0;  ///< How late the system may let a timer be; 0: it adds nothing.
  double spin_us = 0.0;
  std::string remark;  ///< What was refused, and how to get it; empty if nothing was.
};

/// "SCHED_FIFO 80, core 1, memory locked", and the remark.
[[nodiscard]] std::string in_words(const Scheduling& scheduling);

/// Above the kernel's threaded interrupts (50), below its own watchdogs (99).
inline constexpr int kContactPriority = 80;

/// The cores that the calling thread may use, in order.
[[nodiscard]] std::vector<int> allowed_cores();

/// Keeps the calling thread, and the threads that it starts from now on, to these cores; false if that is refused.
bool keep_to_cores(const std::vector<int>& cores) noexcept;

/// Adds a sentence to the remark.
void add_remark(Scheduling& scheduling, const std::string& remark);

/// Keeps the calling thread, and what it starts from now on, off one of its cores, to the end of its scope: that one is
/// for the contact thread alone. Does nothing unless it is wanted, and there are two or more.
class CoreSetAside {
 public:
  /// `core`: one of allowed_cores(); -1: the last of them.
  explicit CoreSetAside(bool wanted, int core = -1);
  ~CoreSetAside();
  CoreSetAside(const CoreSetAside&) = delete;
  CoreSetAside& operator=(const CoreSetAside&) = delete;
  /// -1: none.
  [[nodiscard]] int number() const noexcept { return number_; }
  /// Whether another one like this, of any program on this machine, had set the same core aside before.
  [[nodiscard]] bool taken() const noexcept { return taken_; }

 private:
  std::vector<int> all_;  // The caller's cores, to be given back; empty: they were left alone.
  int number_ = -1;
  int claim_ = -1;  // A socket whose name says to others that the core is taken; -1: none.
  bool taken_ = false;
};

/// Keeps the machine's cores out of sleep that they wake from late, as long as it lives. Only root may, as a rule.
class AwakeCores {
 public:
  AwakeCores() noexcept;
  ~AwakeCores();
  AwakeCores(const AwakeCores&) = delete;
  AwakeCores& operator=(const AwakeCores&) = delete;
  [[nodiscard]] bool granted() const noexcept { return file_ >= 0; }

 private:
  int file_ = -1;
};

/// What the calling thread has, without asking for anything.
[[nodiscard]] Scheduling current_scheduling();

/// Asks for what a loop needs, for the calling thread: SCHED_FIFO, or else timers without slack and short turns; memory
/// locked, which is the whole process' and for good; 256 KB of the thread's stack touched; core `core` (-1: any). A
/// priority of 0 asks for all but SCHED_FIFO. Memory that is taken later is locked page by page, as it is touched.
/// Nothing fails for lack of it: the result says what was granted.
[[nodiscard]] Scheduling ask_for_realtime(int core, int priority = kContactPriority);

/// Gives threads that start from now on, of the whole process, a stack of 2 MB at least: a small `ulimit -s` is else
/// that of each thread, too.
void widen_thread_stacks() noexcept;

/// Makes the calling thread's results below the normal range zero, and takes such operands for zero: the hardware
/// spends a hundred cycles on one otherwise. False if this processor is not known to us.
bool flush_denormals() noexcept;

/// Nanoseconds of the steady clock, CLOCK_MONOTONIC. No system call where the clock is the processor's own.
[[nodiscard]] std::int64_t steady_now_ns() noexcept;

/// Sleeps until `spin_ns` before `time_ns`, then spins; of less time than twice that it sleeps one half, so that a loop
/// with little time left sleeps all the same. Returns the time.
std::int64_t wait_until(std::int64_t time_ns, std::int64_t spin_ns) noexcept;

/// One tick of a loop, as its schedule has it.
struct ScheduledTick {
  std::int64_t deadline_ns = 0;  ///< When it is due.
  std::int64_t slipped = 0;      ///< Ticks given up just before this one.
  bool caught_up = false;        ///< It was due before the one before had ended.
};

/// A rate is kept if so large a share of its ticks is done, and no more slip.
inline constexpr double kKeptShare = 0.99;

/// When the ticks of a loop are due, and what becomes of those that are late. Tick k = 0, 1, 2, … is due at
/// start + k * period. After a tick that took too long at most `max_catch_up` ticks in a row start late; if that has
/// not caught up, the ticks missed are given up: they slip, and the next one is due on the same grid. So a loop that
/// cannot keep its rate loses simulated time, which is counted, and not its rhythm.
///
/// After a slip the next tick is due no sooner than `rest_share` of the time for which the loop has been busy, counted
/// from when its last punctual tick was due: so long a thread can sleep however overloaded it is. A thread under
/// SCHED_FIFO needs a rest of more than 5 %, or the kernel stops it for 50 ms in every second. Of more than one second
/// nothing is to be made up: who was away for an hour, because the process was stopped, goes on soon.
///
/// A period is a nanosecond at least; a tick more than a hundred years away is due in a hundred years.
/// It reads no clock: arithmetic alone. Every tick is either done or slipped: ticks() + slipped() is the number due.
class Schedule {
 public:
  /// Ends after `ticks_due` ticks.
  Schedule(std::int64_t start_ns, double period_s, std::int64_t ticks_due, int max_catch_up,
           double rest_share = 0.0) noexcept
      : start_ns_(start_ns),
        period_ns_(std::clamp(1e9 * period_s, 1.0, kFarthest_ns)),
        ticks_due_(ticks_due),
        max_catch_up_(max_catch_up),
        rest_share_(rest_share) {}

  /// The tick to do next, given that the last one has ended by `now_ns`; nothing after the last.
  [[nodiscard]] std::optional<ScheduledTick> next(std::int64_t now_ns) noexcept;

  /// When the tick after the one that next() gave is due.
  [[nodiscard]] std::int64_t next_deadline_ns() const noexcept { return deadline_ns(index_); }
  [[nodiscard]] std::int64_t ticks() const noexcept { return index_ - slipped_; }
  [[nodiscard]] std::int64_t slipped() const noexcept { return slipped_; }
  /// The most ticks that slipped at once.
  [[nodiscard]] std::int64_t longest_slip() const noexcept { return longest_slip_; }

  /// A time of at least 0, and a hundred years at most.
  [[nodiscard]] static std::int64_t nanoseconds(double time_s) noexcept;

 private:
  // With the clock's own time that is still a number of nanoseconds.
  static constexpr double kFarthest_ns = 1e9 * 100.0 * 365.25 * 86400.0;

  [[nodiscard]] std::int64_t deadline_ns(std::int64_t index) const noexcept;
  /// Of the first tick that is not due before `now_ns`.
  [[nodiscard]] std::int64_t first_not_before(std::int64_t now_ns) const noexcept;

  std::int64_t start_ns_;
  double period_ns_;
  std::int64_t ticks_due_;
  int max_catch_up_;
  double rest_share_;
  std::int64_t index_ = 0;  // of the next tick
  std::int64_t slipped_ = 0, longest_slip_ = 0;
  int caught_up_ = 0;             // in a row
  std::int64_t punctual_ns_ = 0;  // when the last tick that was not late was due
};

}  // namespace thenar
