// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/realtime.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace thenar::realtime_test {
namespace {

constexpr std::int64_t kStart_ns = 1'000'000'007;

/// One tick, and the time at which next() gave it.
struct Given {
  ScheduledTick tick;
  std::int64_t now_ns;
};

/// Runs a schedule on a virtual clock: tick k takes durations_ns[k], and the last one over and over.
std::vector<Given> run(Schedule& schedule, const std::vector<std::int64_t>& durations_ns) {
  std::vector<Given> given;
  std::int64_t now_ns = kStart_ns - 1000;
  while (const auto tick = schedule.next(now_ns)) {
    given.push_back({*tick, now_ns});
    now_ns = std::max(now_ns, tick->deadline_ns) + durations_ns[std::min(given.size(), durations_ns.size()) - 1];
  }
  return given;
}

int catch_ups(const std::vector<Given>& given) {
  return static_cast<int>(std::count_if(given.begin(), given.end(), [](const Given& g) { return g.tick.caught_up; }));
}

TEST(Schedule, ATickInTimeIsDueOnTheGrid) {
  Schedule schedule(kStart_ns, 1e-3 / 3.0, 3000, 2);
  const std::vector<Given> given = run(schedule, {300'000});
  ASSERT_EQ(given.size(), 3000U);
  for (std::size_t k = 0; k < given.size(); ++k) {
    // Rounded to a nanosecond once, not a tick: no drift.
    EXPECT_NEAR(static_cast<double>(given[k].tick.deadline_ns - kStart_ns), static_cast<double>(k) * 1e6 / 3.0, 0.51);
    EXPECT_EQ(given[k].tick.slipped, 0);
    EXPECT_FALSE(given[k].tick.caught_up);
  }
  EXPECT_EQ(schedule.ticks(), 3000);
  EXPECT_EQ(schedule.slipped(), 0);
}

TEST(Schedule, AShortOverrunIsCaughtUpWithoutALoss) {
  Schedule schedule(kStart_ns, 1e-3, 10, 2);
  // Tick 3 ends at 5.5 ms: ticks 4 and 5 are late, tick 6 is in time.
  const std::vector<Given> given = run(schedule, {100'000, 100'000, 100'000, 2'500'000, 100'000});
  ASSERT_EQ(given.size(), 10U);
  for (std::size_t k = 0; k < given.size(); ++k) EXPECT_EQ(given[k].tick.caught_up, k == 4 || k == 5) << k;
  EXPECT_EQ(schedule.slipped(), 0);
}

TEST(Schedule, ALongOverrunSlips) {
  Schedule schedule(kStart_ns, 1e-3, 20, 2);
  // Tick 3 ends at 10.5 ms, ticks 4 and 5 by 10.7 ms: 6 to 10 are given up, and 11 is in time.
  const std::vector<Given> given = run(schedule, {100'000, 100'000, 100'000, 7'500'000, 100'000});
  ASSERT_EQ(given.size(), 15U);
  EXPECT_EQ(catch_ups(given), 2);
  EXPECT_EQ(given[6].tick.slipped, 5);
  EXPECT_EQ(given[6].tick.deadline_ns, kStart_ns + 11'000'000);
  EXPECT_EQ(schedule.slipped(), 5);
  EXPECT_EQ(schedule.ticks(), 15);
}

TEST(Schedule, ALoopThatIsTooSlowLosesTimeAndNotItsGrid) {
  Schedule schedule(kStart_ns, 1e-3, 1000, 2);
  run(schedule, {1'250'000});
  EXPECT_EQ(schedule.ticks() + schedule.slipped(), 1000);
  // Busy all the time but for the wait after a slip, which is less than a period and comes after three ticks at least:
  // between 1000/1.25 and 1000/(1.25 + 1/3) ticks.
  EXPECT_LE(schedule.ticks(), 800);
  EXPECT_GE(schedule.ticks(), 631);
}

// As a contact thread at 4 kHz whose ticks take longer than a step: it must rest for more than the 5 % that the kernel
// wants of a real-time thread.
TEST(Schedule, AnOverloadedLoopRests) {
  constexpr double kPeriod_s = 250e-6;
  for (const double steps : {1.01, 1.3, 1.34, 1.99, 3.0, 30.0}) {
    SCOPED_TRACE(testing::Message() << steps << " steps a tick");
    Schedule schedule(kStart_ns, kPeriod_s, 40'000, 2, 0.1);
    const std::int64_t duration_ns = std::llround(1e9 * kPeriod_s * steps);
    const std::vector<Given> given = run(schedule, {duration_ns});
    EXPECT_EQ(schedule.ticks() + schedule.slipped(), 40'000);
    std::int64_t busy_ns = 0;
    int slips = 0;
    for (std::size_t k = 0; k < given.size(); ++k) {
      if (given[k].tick.slipped > 0) {
        ++slips;
        EXPECT_EQ(busy_ns, 3 * duration_ns) << k;  // A slip comes after three ticks,
        EXPECT_GE(given[k].tick.deadline_ns - given[k].now_ns, busy_ns / 10 - 1) << k;  // and a rest with it.
        busy_ns = 0;
      }
      busy_ns += duration_ns;
    }
    EXPECT_EQ(slips, (static_cast<int>(given.size()) - 1) / 3);
  }
}

// After a stop the kernel has long forgotten how busy the loop was: there is nothing to make up for.
TEST(Schedule, GoesOnSoonAfterALongStop) {
  constexpr std::int64_t kHour_ns = 3'600'000'000'000;
  for (const std::int64_t stop_ns : {3'000'000'000L, 30'000'000'000L, kHour_ns, 24 * 365 * kHour_ns}) {
    SCOPED_TRACE(testing::Message() << "stopped for " << stop_ns << " ns");
    constexpr double kPeriod_s = 100e-6;
    constexpr std::int64_t kPeriod_ns = 100'000;
    Schedule schedule(kStart_ns, kPeriod_s, std::numeric_limits<std::int64_t>::max(), 0, 0.1);
    ASSERT_TRUE(schedule.next(kStart_ns - 1));
    const std::int64_t now_ns = kStart_ns + stop_ns;
    const auto tick = schedule.next(now_ns);
    ASSERT_TRUE(tick);
    // A tenth of a second of rest, as after one second of work; then the next tick of the grid.
    EXPECT_GE(tick->deadline_ns, now_ns + 100'000'000);
    EXPECT_LE(tick->deadline_ns, now_ns + 100'000'000 + kPeriod_ns);
    // Of a year they are 3e11, which is more than 32 bits hold.
    EXPECT_EQ(tick->slipped, (tick->deadline_ns - kStart_ns) / kPeriod_ns - 1);
    EXPECT_EQ(schedule.slipped(), tick->slipped);
    EXPECT_EQ(schedule.longest_slip(), tick->slipped);
    ASSERT_TRUE(schedule.next(tick->deadline_ns + kPeriod_ns / 2));
  }
}

TEST(Schedule, EndsForAnyPeriod) {
  for (const double period_s : {1e-300, 1e-12, 1e9, 1e10, 1e300, std::numeric_limits<double>::infinity()}) {
    SCOPED_TRACE(testing::Message() << period_s << " s");
    Schedule schedule(kStart_ns, period_s, 5, 0, 0.1);
    std::int64_t now_ns = kStart_ns, last_ns = 0;
    while (const auto tick = schedule.next(now_ns)) {
      EXPECT_GE(tick->deadline_ns, kStart_ns);
      EXPECT_GE(tick->deadline_ns, last_ns);
      last_ns = tick->deadline_ns;
      now_ns = std::max(now_ns, last_ns) + 1'000'000;
    }
    EXPECT_EQ(schedule.ticks() + schedule.slipped(), 5);
  }
}

TEST(Schedule, HoldsItsLawsForAnyDurations) {
  std::mt19937_64 random(7);
  for (int run_index = 0; run_index < 500; ++run_index) {
    SCOPED_TRACE(testing::Message() << "seed 7, run " << run_index);
    const double period_s = std::uniform_real_distribution(50e-6, 5e-3)(random);
    const int max_catch_up = static_cast<int>(random() % 4);
    const std::int64_t due = 1 + static_cast<std::int64_t>(random() % 300);
    // Heavy tails: most ticks take a fraction of the period, some many periods.
    std::lognormal_distribution<double> share(-1.0, std::uniform_real_distribution(0.1, 1.5)(random));
    std::vector<std::int64_t> durations_ns(static_cast<std::size_t>(due));
    for (auto& d : durations_ns) d = std::llround(1e9 * period_s * share(random));

    Schedule schedule(kStart_ns, period_s, due, max_catch_up);
    const std::vector<Given> given = run(schedule, durations_ns);
    std::int64_t index = -1, slipped = 0;
    int in_a_row = 0;
    for (const auto& [tick, now_ns] : given) {
      ASSERT_GE(tick.slipped, 0);
      index += 1 + tick.slipped;
      slipped += tick.slipped;
      // On the grid, and the ticks left out are those counted.
      ASSERT_NEAR(static_cast<double>(tick.deadline_ns - kStart_ns), 1e9 * period_s * static_cast<double>(index), 0.51);
      ASSERT_EQ(tick.caught_up, tick.deadline_ns < now_ns);
      in_a_row = tick.caught_up ? in_a_row + 1 : 0;
      ASSERT_LE(in_a_row, max_catch_up);
      if (tick.slipped > 0) {
        ASSERT_FALSE(tick.caught_up);
        // None is given up that could have been in time.
        ASSERT_LT(static_cast<double>(tick.deadline_ns - now_ns), 1e9 * period_s + 1.0);
      }
    }
    EXPECT_EQ(std::ssize(given), schedule.ticks());
    EXPECT_GE(schedule.slipped(), slipped);  // The last ones may have slipped too.
    EXPECT_EQ(schedule.ticks() + schedule.slipped(), due);
  }
}

TEST(Realtime, WaitsToTheDeadlineAndNotLess) {
  for (const std::int64_t spin_ns : {0, 50'000, 10'000'000}) {
    const std::int64_t due_ns = steady_now_ns() + 2'000'000;
    EXPECT_GE(wait_until(due_ns, spin_ns), due_ns);
    EXPECT_GE(steady_now_ns(), due_ns);
  }
  // Too little time for the spin that is asked for is not spun away: the processor has rested.
  const auto processor_ns = [] {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1'000'000'000 * static_cast<std::int64_t>(time.tv_sec) + time.tv_nsec;
  };
  const std::int64_t before_ns = processor_ns();
  wait_until(steady_now_ns() + 20'000'000, 40'000'000);
  EXPECT_LT(processor_ns() - before_ns, 15'000'000);
  // What is past is not waited for.
  const std::int64_t now_ns = steady_now_ns();
  EXPECT_GE(wait_until(now_ns - 1'000'000'000, 50'000), now_ns);
}

TEST(Realtime, FlushesDenormalsOfItsThreadAlone) {
  const volatile double least = std::numeric_limits<double>::min();
  std::thread([&least] {
    EXPECT_NE(least * 0.5, 0.0);
#if defined(__SSE2__) || defined(__aarch64__)
    EXPECT_TRUE(flush_denormals());
#endif
    if (!flush_denormals()) GTEST_SKIP() << "not on this processor";
    EXPECT_TRUE(current_scheduling().denormals_flushed);
    EXPECT_EQ(least * 0.5, 0.0);  // a result below the normal range
    const volatile double denormal = std::numeric_limits<double>::denorm_min();
    EXPECT_EQ(denormal * 1e300, 0.0);  // an operand
  }).join();
  EXPECT_FALSE(current_scheduling().denormals_flushed);
  EXPECT_NE(least * 0.5, 0.0);
}

TEST(Realtime, SaysWhatItWasGrantedOrHowToGetIt) {
  const std::vector<int> cores = allowed_cores();
  ASSERT_FALSE(cores.empty());
  std::thread([&cores] {
    const Scheduling granted = ask_for_realtime(cores.back());
    EXPECT_EQ(granted.core, cores.back());
    EXPECT_EQ(allowed_cores(), std::vector<int>{cores.back()});
    // Neither a timer of a real-time thread nor one of ours is late on purpose.
    EXPECT_LE(granted.timer_slack_ns, 1.0);
    if (granted.policy == "SCHED_FIFO") {
      EXPECT_EQ(granted.priority, kContactPriority);
    } else {
      EXPECT_NE(granted.remark.find("rtprio"), std::string::npos) << granted.remark;
    }
    EXPECT_EQ(granted.memory_locked, granted.remark.find("memlock") == std::string::npos) << granted.remark;
  }).join();
  EXPECT_EQ(allowed_cores(), cores);
  EXPECT_NE(current_scheduling().policy, "SCHED_FIFO");
}

TEST(Realtime, SetsACoreAsideAndSaysWhoHasItAlready) {
  const std::vector<int> cores = allowed_cores();
  {
    const CoreSetAside unwanted(false);
    EXPECT_EQ(unwanted.number(), -1);
    EXPECT_EQ(allowed_cores(), cores);
  }
  if (cores.size() < 2) GTEST_SKIP() << "there is one core";
  for (const int wished : {-1, cores.front()}) {
    const CoreSetAside mine(true, wished);
    const int core = wished < 0 ? cores.back() : wished;
    EXPECT_EQ(mine.number(), core);
    std::vector<int> others = cores;
    std::erase(others, core);
    EXPECT_EQ(allowed_cores(), others);
    // Another program, which may use all cores.
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      keep_to_cores(cores);
      const CoreSetAside same(true, core);
      _exit(same.number() == core && same.taken() ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(allowed_cores(), cores);
  // It is free again, once no other test has it.
  bool taken = true;
  for (int i = 0; taken && i < 600; ++i) {
    taken = CoreSetAside(true).taken();
    if (taken) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_FALSE(taken);
}

// With `ulimit -s 256` a thread's stack is no larger than what a contact thread touches.
TEST(Realtime, ThreadsHaveRoomWhateverTheLimitIs) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a thread of ThreadSanitizer takes more than the least stack";
#endif
  pthread_attr_t before;
  ASSERT_EQ(pthread_getattr_default_np(&before), 0);
  pthread_attr_t small;
  ASSERT_EQ(pthread_getattr_default_np(&small), 0);
  pthread_attr_setstacksize(&small, 128 * 1024);
  ASSERT_EQ(pthread_setattr_default_np(&small), 0);
  // Too little is told, and not touched.
  std::string remark;
  std::thread([&remark] { remark = ask_for_realtime(-1, 0).remark; }).join();
  EXPECT_NE(remark.find("KB of stack left"), std::string::npos) << remark;
  widen_thread_stacks();
  std::thread([&remark] { remark = ask_for_realtime(-1, 0).remark; }).join();
  EXPECT_EQ(remark.find("KB of stack left"), std::string::npos) << remark;
  pthread_setattr_default_np(&before);
  pthread_attr_destroy(&small);
  pthread_attr_destroy(&before);
}

TEST(Realtime, WithoutAPriorityAsksForTheRest) {
  std::thread([] {
    const Scheduling granted = ask_for_realtime(-1, 0);
    EXPECT_EQ(granted.policy, "SCHED_OTHER");
    EXPECT_LE(granted.timer_slack_ns, 1.0);
    EXPECT_EQ(granted.remark.find("SCHED_FIFO"), std::string::npos) << granted.remark;
  }).join();
}

/// Of the process, as the system counts it.
std::int64_t resident_bytes() {
  std::int64_t size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

// A run takes room for all its records when it begins: what it has not used yet must not take the machine's memory.
TEST(Realtime, LocksWhatIsTouchedOfMemoryTakenLater) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    constexpr std::size_t kBytes = 512 << 20;
    if (!ask_for_realtime(-1, 0).memory_locked) _exit(2);
    const std::int64_t before = resident_bytes();
    const std::unique_ptr<char[]> block(new char[kBytes]);  // not written to
    volatile char& first = block[0];
    first = 1;
    _exit(resident_bytes() - before < 16 << 20 ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 2) GTEST_SKIP() << "memory is not locked here";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(Realtime, AnImpossibleCoreIsARemark) {
  std::thread([] {
    const std::vector<int> cores = allowed_cores();
    const Scheduling granted = ask_for_realtime(1000);
    EXPECT_NE(granted.remark.find("core 1000"), std::string::npos) << granted.remark;
    EXPECT_EQ(allowed_cores(), cores);
  }).join();
}

}  // namespace
}  // namespace thenar::realtime_test
