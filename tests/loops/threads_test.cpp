// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/threads.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/loops/live_contact.h"
#include "engine/loops/realtime.h"
#include "engine/loops/split_grasp.h"
#include "engine/models/build_model.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"
#include "tests/support/seccomp_trap.h"

namespace thenar::threads_test {
namespace {

#if defined(__SANITIZE_THREAD__)
constexpr double kThreadedRun_s = 5.0;
#else
constexpr double kThreadedRun_s = 1.5;
#endif

bool is_finite(const Snapshot& snapshot) {
  bool finite = snapshot.q.allFinite() && snapshot.X_WO.matrix().allFinite();
  for (const FingerLoad& load : snapshot.load) finite = finite && load.force_N.allFinite();
  return finite;
}

/// Control steps at the model's control period in a thread of their own, to the end of its scope.
std::jthread control_thread(SplitGrasp& grasp, double period_s) {
  return std::jthread([&grasp, period_s](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::this_thread::sleep_for(std::chrono::duration<double>(period_s));
      grasp.control_step();
    }
  });
}

TEST(Threads, HoldABoxWithoutLosingARecord) {
  const Model model = build_model(split_scene());
  State state(model);
  const std::vector<int> cores = allowed_cores();
  std::int64_t samples = 0, slipped = 0, disordered = 0, bad = 0, early = 0, control_samples = 0, control_disorder = 0;
  std::int64_t last_sequence = 0, last_deadline_ns = 0;

  ThreadSettings settings;
  settings.duration_s = kThreadedRun_s;
  settings.on_tick = [&](const ContactSample& sample) {
    ++samples;
    slipped += sample.slipped;
    if (sample.after.tick != samples || sample.step.tick.sequence < last_sequence) ++disordered;
    if (sample.start_ns < sample.deadline_ns || sample.deadline_ns <= last_deadline_ns) ++early;
    if (!is_finite(sample.after)) ++bad;
    last_sequence = sample.step.tick.sequence;
    last_deadline_ns = sample.deadline_ns;
    return true;
  };
  settings.on_control = [&](const ControlSample& sample) {
    ++control_samples;
    if (sample.step.sequence != control_samples) ++control_disorder;
    if (!sample.muscle_forces_N.allFinite() || sample.muscle_forces_N.size() == 0) ++bad;
  };
  const ThreadsReport report = run_threads(model, state, settings);

  EXPECT_EQ(report.ticks + report.slipped, std::lround(kThreadedRun_s / 1e-3));
  EXPECT_EQ(report.lost_samples, 0);
  EXPECT_EQ(report.lost_control_samples, 0);
  EXPECT_EQ(samples, report.ticks);
  EXPECT_LE(slipped, report.slipped);  // The last ones may have slipped too.
  EXPECT_EQ(disordered, 0);
  EXPECT_EQ(early, 0);
  EXPECT_EQ(bad, 0);
  EXPECT_EQ(control_disorder, 0);
  EXPECT_GT(control_samples, 1);
  for (const ExchangeCounts& counts : {report.frames, report.snapshots}) {
    EXPECT_EQ(counts.torn, 0);
    EXPECT_EQ(counts.unaccounted(), 0);
  }
  EXPECT_EQ(report.frames.published, 1 + control_samples);
  EXPECT_EQ(report.snapshots.published, report.ticks);
  EXPECT_EQ(state.tick, report.ticks);
  EXPECT_TRUE(is_finite(state));
  EXPECT_EQ(allowed_cores(), cores);
  EXPECT_EQ(report.contact.core, cores.back());  // also where there is no other
}

TEST(Threads, EndWhenTheReceiverSaysSo) {
  const Model model = build_model(scene_of("minimal"));
  State state(model);
  int received = 0;
  ThreadSettings settings;
  settings.duration_s = 60.0;
  settings.realtime = false;
  settings.on_tick = [&](const ContactSample&) { return ++received < 20; };
  const ThreadsReport report = run_threads(model, state, settings);
  EXPECT_EQ(received, 20);
  EXPECT_GE(report.ticks, 20);
  EXPECT_LT(report.wall_s, 30.0);
  EXPECT_EQ(state.tick, report.ticks);
  EXPECT_EQ(report.contact.policy, "SCHED_OTHER");
  EXPECT_EQ(report.contact.remark, "");
}

TEST(Threads, GoOnWithTheSameGraspAndAtAnotherSpeed) {
  const Model model = build_model(split_scene());
  SplitGrasp grasp(model);
  ThreadSettings settings;
  settings.realtime = false;
  settings.quiet = true;
  settings.duration_s = 0.3;
  std::int64_t ticks = 0, samples = 0, disordered = 0, off_grid = 0, first_ns = 0;
  settings.on_tick = [&](const ContactSample& sample) {
    if (sample.after.tick != ++samples) ++disordered;
    return true;
  };
  for (int i = 0; i < 2; ++i) ticks += run_threads(grasp, settings).ticks;
  EXPECT_EQ(grasp.state().tick, ticks);
  EXPECT_EQ(disordered, 0);
  // Ten times as slow: ticks are due every 10 ms of the wall's clock, and control acts as often in simulated time.
  settings.speed = 0.1;
  settings.duration_s = 0.05;
  settings.on_tick = [&](const ContactSample& sample) {
    if (first_ns == 0) first_ns = sample.deadline_ns;
    if ((sample.deadline_ns - first_ns) % 10'000'000 != 0) ++off_grid;
    return true;
  };
  const ThreadsReport slow = run_threads(grasp, settings);
  EXPECT_EQ(slow.ticks + slow.slipped, 50);
  EXPECT_EQ(off_grid, 0);
  EXPECT_EQ(disordered, 0);
  EXPECT_EQ(slow.frames.unaccounted(), 0);
  EXPECT_EQ(slow.snapshots.unaccounted(), 0);
  // One tick in 2000 s: a stop does not wait for it.
  settings.speed = 1e-6;
  settings.on_look = [looks = 0]() mutable { return ++looks < 5; };
  EXPECT_LE(run_threads(grasp, settings).ticks, 1);
}

TEST(Threads, SayWhichTickSawAnInputFirst) {
  const Model model = build_model(split_scene());
  SplitGrasp grasp(model);
  LatestValue<LiveInput> inputs;
  LiveHands hands(model);
  LiveContact live(model, inputs, hands);
  LiveInput input;
  input.number = 1;
  input.stamp_ns = 12345;
  inputs.draft() = input;
  inputs.publish();
  ThreadSettings settings;
  settings.realtime = false;
  settings.duration_s = 0.05;
  settings.live = &live;
  std::vector<std::int64_t> stamped;
  int shown = 0;
  settings.on_tick = [&](const ContactSample& sample) {
    if (sample.stamp_ns != 0) stamped.push_back(sample.after.tick);
    shown += sample.shown;
    return true;
  };
  run_threads(grasp, settings);
  EXPECT_EQ(stamped, std::vector<std::int64_t>{1});
  EXPECT_EQ(shown, 0);  // Nobody looks.
}

TEST(Threads, EndWhenTheReceiverThrows) {
  const Model model = build_model(scene_of("minimal"));
  State state(model);
  const std::vector<int> cores = allowed_cores();
  ThreadSettings settings;
  settings.duration_s = 60.0;
  settings.on_tick = [](const ContactSample&) -> bool { throw std::runtime_error("enough"); };
  EXPECT_THROW(run_threads(model, state, settings), std::runtime_error);
  EXPECT_EQ(allowed_cores(), cores);
}

// A record of control owns memory. Those of many ticks wait while the receiver is away; it throws at the third of them.
TEST(Threads, LeaveNoRecordTwiceWhenTheReceiverThrows) {
  const Model model = build_model(split_scene());
  SplitGrasp grasp(model);
  ThreadSettings settings;
  settings.duration_s = 60.0;
  settings.realtime = false;
  settings.quiet = true;
  settings.on_look = [] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return true;
  };
  for (int run = 0; run < 3; ++run) {
    int received = 0;
    settings.on_control = [&received](const ControlSample& sample) {
      EXPECT_GT(sample.muscle_forces_N.size(), 0);  // or there is nothing to free
      if (++received == 3) throw std::runtime_error("no room");
    };
    EXPECT_THROW(run_threads(grasp, settings), std::runtime_error);
    EXPECT_EQ(received, 3);
  }
  settings.on_control = {};
  settings.on_look = []() -> bool { throw std::runtime_error("no look"); };
  EXPECT_THROW(run_threads(grasp, settings), std::runtime_error);
  settings.on_look = {};
  settings.on_start = [](const Scheduling&) { throw std::runtime_error("no start"); };
  EXPECT_THROW(run_threads(grasp, settings), std::runtime_error);
}

/// What a child that was stopped tells, in memory that it shares with the test.
struct StopResult {
  std::atomic<bool> running{false};
  std::int64_t most_slipped = 0, rest_ns = 0, lost = -1;
  double longest_slip_s = 0.0;
};

[[noreturn]] void run_to_be_stopped(const Model& model, StopResult& result) {
  SplitGrasp grasp(model);
  ThreadSettings settings;
  settings.duration_s = 30.0;
  settings.realtime = false;
  settings.quiet = true;
  std::int64_t last_end_ns = 0;
  int after = 0;
  settings.on_tick = [&](const ContactSample& sample) {
    if (sample.after.tick == 50) result.running = true;
    if (sample.slipped > result.most_slipped) {
      result.most_slipped = sample.slipped;
      result.rest_ns = sample.deadline_ns - last_end_ns;
    }
    last_end_ns = sample.end_ns;
    return result.most_slipped < 1000 || ++after < 100;
  };
  const ThreadsReport report = run_threads(grasp, settings);
  result.longest_slip_s = report.longest_slip_s;
  result.lost = report.lost_samples;
  _exit(0);
}

// As by Ctrl-Z, a debugger, or a machine that sleeps.
TEST(Threads, GoOnSoonAfterTheProcessWasStopped) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "ThreadSanitizer's own thread does not outlive a fork";
#endif
  const Model model = build_model(split_scene());
  void* const page = mmap(nullptr, sizeof(StopResult), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(page, MAP_FAILED);
  StopResult& result = *new (page) StopResult;
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) run_to_be_stopped(model, result);
  for (int i = 0; i < 2000 && !result.running; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  kill(child, SIGSTOP);
  std::this_thread::sleep_for(std::chrono::seconds(3));
  kill(child, SIGCONT);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  // The ticks of 1 ms that were due meanwhile are given up, but for those that are caught up. From the end of the last
  // of these to the next tick are 0.1 s at most, and what is left of a step.
  EXPECT_GE(result.most_slipped, 2900);
  EXPECT_GE(result.longest_slip_s, 2.9);
  EXPECT_LE(result.rest_ns, 101'000'000);
  EXPECT_EQ(result.lost, 0);
  munmap(page, sizeof(StopResult));
}

TEST(Threads, SayHowManyRecordsTheyLost) {
  const Model model = build_model(split_scene());
  SplitGrasp grasp(model);
  std::int64_t kept = 0, told = 0;
  const std::function<bool(const ContactSample&)> keep = [&](const ContactSample& sample) {
    // Of every ten one is kept, which says how many were lost before it.
    if (sample.after.tick % 10 != 0) return false;
    ++kept;
    told = sample.lost;
    EXPECT_EQ(sample.lost, sample.after.tick - kept);
    return true;
  };
  const std::stop_token never;
  const ContactLoopCounts counts =
      run_contact_loop(grasp, Schedule(steady_now_ns(), model.scene.step_s, 95, 95), 0, keep, never);
  EXPECT_EQ(kept, 9);
  EXPECT_EQ(told, 81);
  EXPECT_EQ(counts.lost_samples, 86);
}

// A receiver that is away for longer than the ring has room loses records: the next one says so, of both threads.
TEST(Threads, RecordsThatAreLostAreCountedInTheNextOne) {
  const Model model = build_model(split_scene());
  SplitGrasp grasp(model);
  ThreadSettings settings;
  settings.duration_s = 6.0;  // Under a sanitizer, too, more ticks than the ring has room for.
  settings.realtime = false;
  settings.quiet = true;
  settings.on_look = [away = false]() mutable {
    if (!std::exchange(away, true)) std::this_thread::sleep_for(std::chrono::milliseconds(5600));
    return true;
  };
  std::int64_t contact = 0, control = 0, before = 0, missing = 0;
  settings.on_tick = [&](const ContactSample& sample) {
    missing += sample.after.tick - before - 1;
    before = sample.after.tick;
    contact = sample.lost;
    EXPECT_EQ(contact, missing);
    return true;
  };
  settings.on_control = [&](const ControlSample& sample) { control = sample.lost; };
  const ThreadsReport report = run_threads(grasp, settings);
  // The ring has room for 2 s of ticks: fewer in all lose nothing, as where ThreadSanitizer takes its time.
  if (report.ticks < 2100) GTEST_SKIP() << report.ticks << " ticks fit into the ring";
  EXPECT_GT(contact, 0);
  EXPECT_GT(control, 0);
  EXPECT_EQ(contact, report.lost_samples);
  EXPECT_EQ(control, report.lost_control_samples);
}

TEST(Threads, DoNotStartWithoutGraspForces) {
  // Without friction the fingers' normals, all along the grip axis, cannot carry the weight across it.
  const Model model = build_model(scene_of("box_grasp", {kCoarseBox, "control.grasp.friction=0"}));
  State state(model);
  ThreadSettings settings;
  settings.duration_s = 60.0;
  const ThreadsReport report = run_threads(model, state, settings);
  EXPECT_NE(report.first_control.grasp, GraspStatus::kOptimal);
  EXPECT_EQ(report.ticks, 0);
  EXPECT_EQ(state.tick, 0);
}

/// People at a contact loop: inputs of all kinds go in, pictures and problems are taken, to the end of the scope.
struct People {
  explicit People(const Model& model) : hands(model), live(model, inputs, hands) {
    const Eigen::Vector3d handle = model.scene.object.X_WO.translation() + Eigen::Vector3d(0.0, 0.0, 3e-3);
    live.watched = true;
    live.picture_ticks = 3;
    live.problem_ticks = 7;
    thread = std::jthread([this, handle](const std::stop_token& stop) {
      LiveInput input;
      while (!stop.stop_requested()) {
        ++input.number;
        input.stamp_ns = input.pull_heard_ns = steady_now_ns();
        input.pull = LiveInput::Pull{Eigen::Vector3d::Zero(), handle};
        input.pokes = input.number / 20;
        input.poke_N = Eigen::Vector3d(0.0, 0.0, 1.0);
        input.target_shift_m = Eigen::Vector3d(0.0, 2e-3, 0.0);
        inputs.draft() = input;
        inputs.publish();
        if (live.pictures.take()) ++pictures;
        if (live.problems.take()) ++problems;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
  }

  LatestValue<LiveInput> inputs;
  LiveHands hands;
  LiveContact live;
  std::atomic<int> pictures{0}, problems{0};
  std::jthread thread;
};

/// What a run's records go through, with room for a whole test: so the copy and the push of each are under test as
/// well.
using Ring = boost::lockfree::spsc_queue<ContactSample, boost::lockfree::capacity<1024>>;

// In the thread of the loop itself, beside a control thread that keeps frames coming.
TEST(Threads, ContactLoopTakesNoMemory) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  const Model model = build_model(split_scene());
  SplitGrasp grasp(model);
  const auto ring = std::make_unique<Ring>();
  std::int64_t handed_over = 0, stamps = 0, shown = 0;
  const std::function<bool(const ContactSample&)> keep = [&](const ContactSample& sample) {
    if (sample.step.tick.handed_over) ++handed_over;
    if (sample.stamp_ns != 0) ++stamps;
    if (sample.shown) ++shown;
    return ring->push(sample);
  };
  People people(model);
  const std::jthread control = control_thread(grasp, model.scene.control_period_s);
  const std::stop_token never;
  const AllocationCounter counter;
  const ContactLoopCounts counts = run_contact_loop(
      grasp, Schedule(steady_now_ns() + 1'000'000, model.scene.step_s, 500, 2), 50'000, keep, never, &people.live);
  EXPECT_EQ(counter.count(), 0);
  EXPECT_GT(stamps, 1);
  EXPECT_GT(shown, 1);
  EXPECT_GT(people.pictures, 1);
  EXPECT_GT(people.problems, 1);
  EXPECT_EQ(counts.ticks + counts.slipped, 500);
  EXPECT_EQ(counts.lost_samples, 0);
  EXPECT_GT(handed_over, 1);
}

/// What a child process has found, in memory that it shares with the test.
struct TrapResult {
  bool set = false;
  std::int64_t violations = 0;  ///< In the loop.
  long last = -1;
  std::int64_t after_write = 0, after_large_block = 0;  ///< With a write, then with a large block of memory.
  std::int64_t ticks = 0, handed_over = 0, lost = -1, pictures = 0;
  double denormal_product = -1.0;
};

/// Runs a contact loop of 600 ticks at 1 kHz under the trap, then breaks its rules on purpose. Ends the process.
[[noreturn]] void run_trapped(const Model& model, TrapResult& result) {
  SplitGrasp grasp(model);
  const auto ring = std::make_unique<Ring>();
  People people(model);
  const std::jthread control = control_thread(grasp, model.scene.control_period_s);
  std::jthread contact([&] {
    const std::function<bool(const ContactSample&)> keep = [&result, &ring](const ContactSample& sample) {
      if (sample.step.tick.handed_over) ++result.handed_over;
      return ring->push(sample);
    };
    const std::stop_token never;
    flush_denormals();
    result.set = SeccompTrap::set();
    if (!result.set) _exit(0);
    const Schedule schedule(steady_now_ns() + 1'000'000, model.scene.step_s, 600, 2);
    const ContactLoopCounts counts = run_contact_loop(grasp, schedule, 50'000, keep, never, &people.live);
    result.pictures = people.pictures;
    result.ticks = counts.ticks + counts.slipped;
    result.lost = counts.lost_samples;
    result.violations = SeccompTrap::count();
    result.last = SeccompTrap::last();
    const volatile double least = std::numeric_limits<double>::min();
    result.denormal_product = least * 0.5;

    [[maybe_unused]] const auto written = write(STDERR_FILENO, "", 0);
    result.after_write = SeccompTrap::count();
    void* volatile block = std::malloc(64 << 20);  // larger than the allocator has: it asks the system
    std::free(block);
    result.after_large_block = SeccompTrap::count();
    _exit(0);  // with all threads: ending this one alone would take calls that are trapped
  });
  contact.join();
  _exit(1);
}

/// Whether the processor's own clock serves, so that reading it calls no system.
bool clock_is_local() {
  std::string source;
  std::ifstream("/sys/devices/system/clocksource/clocksource0/current_clocksource") >> source;
  return source == "tsc" || source == "kvm-clock" || source == "arch_sys_counter" ||
         source == "hyperv_clocksource_tsc_page";
}

TEST(Threads, ContactLoopCallsTheSystemOnlyToSleep) {
  if (!SeccompTrap::is_available()) GTEST_SKIP() << "no seccomp filter here, or under a sanitizer";
  if (!clock_is_local()) GTEST_SKIP() << "reading this machine's clock is a system call";
  const Model model = build_model(split_scene());
  void* const page = mmap(nullptr, sizeof(TrapResult), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(page, MAP_FAILED);
  TrapResult& result = *new (page) TrapResult;
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) run_trapped(model, result);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  if (!result.set) GTEST_SKIP() << "the system refused the filter";

  EXPECT_EQ(result.violations, 0) << "the last one was system call " << result.last;
  EXPECT_EQ(result.ticks, 600);
  EXPECT_EQ(result.lost, 0);
  EXPECT_GT(result.handed_over, 10);
  EXPECT_GT(result.pictures, 1);
  EXPECT_EQ(result.denormal_product, 0.0);
  // The trap does catch: a write, and memory from the system.
  EXPECT_EQ(result.after_write, result.violations + 1);
  EXPECT_GT(result.after_large_block, result.after_write);
  munmap(page, sizeof(TrapResult));
}

}  // namespace
}  // namespace thenar::threads_test
