// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace thenar {

/// The scheduling that the system granted a thread.
struct Scheduling {
  std::string policy = "SCHED_OTHER";  ///< Policy; or "SCHED_FIFO".
  int priority = 0;
  int core = -1;  ///< Core to which it is pinned; -1: any.
  bool memory_locked = false;
  bool kept_awake = false;  ///< True if no core of the machine sleeps so deeply that it wakes late.
  bool denormals_flushed = false;
  double timer_slack_ns = 0.0;  ///< Lateness that the system allows a timer; 0: none.
  double spin_us = 0.0;
  std::string remark;  ///< Refused requests and remedies; empty if none.
};

/// Describes it: "SCHED_FIFO 80, core 1, memory locked", and the remark.
[[nodiscard]] std::string in_words(const Scheduling& scheduling);

/// Priority of the contact thread, above the kernel's threaded interrupts (50), below its watchdogs (99).
inline constexpr int kContactPriority = 80;

/// Returns the cores that the calling thread may use, in order.
[[nodiscard]] std::vector<int> allowed_cores();

/// Restricts the calling thread, and threads that it starts later, to these cores; false if that is refused.
bool keep_to_cores(const std::vector<int>& cores) noexcept;

/// Adds a sentence to the remark.
void add_remark(Scheduling& scheduling, const std::string& remark);

/// A scope that keeps the calling thread, and threads that it starts later, off one of its cores, which is reserved for
/// the contact thread. Does nothing unless it is wanted, and there are two or more cores.
class CoreSetAside {
 public:
  /// `core`: one of allowed_cores(); -1: the last of them.
  explicit CoreSetAside(bool wanted, int core = -1);
  ~CoreSetAside();
  CoreSetAside(const CoreSetAside&) = delete;
  CoreSetAside& operator=(const CoreSetAside&) = delete;
  /// Returns the core; -1: none.
  [[nodiscard]] int number() const noexcept { return number_; }
  /// Tests whether another one like this, of any program on this machine, had reserved the same core before.
  [[nodiscard]] bool taken() const noexcept { return taken_; }

 private:
  std::vector<int> all_;  // The caller's cores, to be restored; empty: unchanged.
  int number_ = -1;
  int claim_ = -1;  // A socket whose name marks the core as taken; -1: none.
  bool taken_ = false;
};

/// A scope that keeps the machine's cores out of sleep states with late wake-up. Usually only root may.
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

/// Returns the scheduling of the calling thread, without any request.
[[nodiscard]] Scheduling current_scheduling();

/// Requests real-time scheduling for the calling thread: SCHED_FIFO, or else timers without slack and short time
/// slices; locked memory, for the whole process and permanently; 256 KB of the thread's stack touched; core `core` (-1:
/// any). A priority of 0 requests all but SCHED_FIFO. Memory that is allocated later is locked page by page, as it is
/// touched. No refusal is an error: the result says what was granted.
[[nodiscard]] Scheduling ask_for_realtime(int core, int priority = kContactPriority);

/// Gives threads of the process that start later a stack of at least 2 MB, which a small `ulimit -s` would else reduce.
void widen_thread_stacks() noexcept;

/// Flushes denormal results of the calling thread to zero, and treats such operands as zero: the hardware spends a
/// hundred cycles on one otherwise. False if this processor is not supported.
bool flush_denormals() noexcept;

/// Returns nanoseconds of the steady clock, CLOCK_MONOTONIC. No system call where the clock is the processor's own.
[[nodiscard]] std::int64_t steady_now_ns() noexcept;

/// Sleeps until `spin_ns` before `time_ns`, then spins; if less than twice that time remains it sleeps half of it, so
/// that a loop with little time left sleeps, too. Returns the time.
std::int64_t wait_until(std::int64_t time_ns, std::int64_t spin_ns) noexcept;

/// One tick in the schedule of a loop.
struct ScheduledTick {
  std::int64_t deadline_ns = 0;  ///< Time at which it is due.
  std::int64_t slipped = 0;      ///< Ticks given up just before this one.
  bool caught_up = false;        ///< True if it was due before the one before had ended.
};

/// A rate is kept if at least this share of its ticks is done, and the others slip.
inline constexpr double kKeptShare = 0.99;

/// The schedule of a loop: when ticks are due, and the treatment of late ones. Tick k = 0, 1, 2, … is due at
/// start + k * period. After a tick that took too long at most `max_catch_up` ticks in a row start late; if that has
/// not caught up, the missed ticks are dropped: they slip, and the next one is due on the same grid. So a loop that
/// cannot keep its rate loses simulated time, which is counted, but keeps its phase.
///
/// After a slip the next tick is due no sooner than after a rest of `rest_share` of the time for which the loop has
/// been busy since its last punctual tick was due, so that an overloaded thread sleeps, too. A thread under SCHED_FIFO
/// needs a rest of more than 5 %, or the kernel stops it for 50 ms in every second. Busy time counts up to one second:
/// a process that was stopped for an hour soon continues.
///
/// A period is a nanosecond at least; a tick more than a hundred years away is due in a hundred years.
/// It reads no clock. Every tick is either done or slipped: ticks() + slipped() is the number due.
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

  /// Returns the next tick, given that the last one has ended by `now_ns`; nothing after the last.
  [[nodiscard]] std::optional<ScheduledTick> next(std::int64_t now_ns) noexcept;

  /// Returns when the tick after the one of next() is due.
  [[nodiscard]] std::int64_t next_deadline_ns() const noexcept { return deadline_ns(index_); }
  [[nodiscard]] std::int64_t ticks() const noexcept { return index_ - slipped_; }
  [[nodiscard]] std::int64_t slipped() const noexcept { return slipped_; }
  /// Returns the largest number of ticks that slipped at once.
  [[nodiscard]] std::int64_t longest_slip() const noexcept { return longest_slip_; }

  /// Converts a time to nanoseconds, clamped to 0 .. a hundred years.
  [[nodiscard]] static std::int64_t nanoseconds(double time_s) noexcept;

 private:
  // Added to the clock's time, it still fits.
  static constexpr double kFarthest_ns = 1e9 * 100.0 * 365.25 * 86400.0;

  [[nodiscard]] std::int64_t deadline_ns(std::int64_t index) const noexcept;
  /// Returns the index of the first tick that is not due before `now_ns`.
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
