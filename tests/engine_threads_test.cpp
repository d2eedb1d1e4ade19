#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/lockfree/spsc_queue.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "engine/realtime.h"
#include "engine/split_grasp.h"
#include "engine/threads.h"
#include "tests/allocation_counter.h"
#include "tests/scenes.h"
#include "tests/seccomp_trap.h"

namespace thenar {
namespace {

#if defined(__SANITIZE_THREAD__)
constexpr double kThreadedRun_s = 5.0;
#else
constexpr double kThreadedRun_s = 1.5;
#endif

/// The box grasp as two threads run it: contact at 1 kHz, control at 200 Hz.
Scene split_scene() { return scene_of("box_grasp", {kCoarseBox, "time.step=1 ms", "time.control_period=5 ms"}); }

bool is_finite(const State& state) {
  bool finite = state.q.allFinite() && state.X_WO.matrix().allFinite();
  for (const auto& u : state.u_m) finite = finite && u.allFinite();
  for (const ContactForce& force : state.forces) finite = finite && force.f_C.allFinite();
  return finite;
}

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

// The exchange adds nothing to the two ticks: the same calls in the same order, on a frame and a snapshot handed over
// by hand, give the same bits; so a draft's old contents do not leak into a frame either.
TEST(SplitGrasp, IsTheTwoTicksAndAnExchange) {
  const Model model(split_scene());
  SplitGrasp grasp(model);

  State state(model);
  Frame frame(model);
  Controller controller(model);
  ContactWorkspace work(model, split_policy(model.scene));
  control_tick(model, state, controller, frame);
  EXPECT_GE(grasp.first_control().total_s, 0.0);
  EXPECT_GT(grasp.first_control().f_desired.norm(), 0.0);

  for (int tick = 0; tick < 300; ++tick) {
    if (tick > 0 && model.control_is_due(tick)) {
      control_tick(model, state, controller, frame);
      const ControlStep step = grasp.control_step();
      EXPECT_TRUE(step.published);
      EXPECT_EQ(step.sequence, frame.sequence);
      EXPECT_EQ(step.snapshot_tick, tick);
    }
    const TickReport report = contact_tick(model, frame, work, state);
    const ContactStep step = grasp.contact_step();
    ASSERT_EQ(step.tick.sequence, report.sequence);
    ASSERT_EQ(step.tick.handed_over, report.handed_over);
    ASSERT_EQ(grasp.state().q, state.q) << tick;
    ASSERT_EQ(grasp.state().X_WO.matrix(), state.X_WO.matrix()) << tick;
  }
  EXPECT_GT(state.load[0].normal_N, 0.5);  // It does hold the box.
  EXPECT_EQ(grasp.frames().counts().published, 60);
  EXPECT_EQ(grasp.frames().counts().consumed, 60);
  EXPECT_EQ(grasp.snapshots().counts().published, 300);
}

TEST(SplitGrasp, ContactStepsTakeNoMemoryFromTheFirstOn) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  const Model model(split_scene());
  State start(model);
  start.forces.shrink_to_fit();  // as a copy of a state has none to spare
  SplitGrasp grasp(model, start);
  std::int64_t allocations = 0;
  for (int tick = 0; tick < 200; ++tick) {
    if (tick % 5 == 4) grasp.control_step();
    const AllocationCounter counter;
    const ContactStep step = grasp.contact_step();
    allocations += counter.count();
    ASSERT_EQ(step.tick.handed_over, tick % 5 == 4 || tick == 0);
  }
  EXPECT_EQ(allocations, 0);
}

TEST(SplitGrasp, StaysFiniteWhateverTheInput) {
  const Model model(split_scene());
  SplitGrasp grasp(model);
  TickInput bad;
  bad.wrench[1] = std::numeric_limits<double>::quiet_NaN();
  bad.X_WT = Eigen::Isometry3d::Identity();
  bad.X_WT->translation().x() = std::numeric_limits<double>::infinity();
  for (int tick = 0; tick < 200; ++tick) {
    if (tick % 5 == 4) grasp.control_step();
    const ContactStep step = grasp.contact_step(tick == 50 ? bad : TickInput{});
    ASSERT_EQ(step.tick.input_refused, tick == 50);
    ASSERT_TRUE(is_finite(grasp.state())) << tick;
  }
}

TEST(SplitGrasp, RefusesAFirstFrameThatIsNotFinite) {
  const Model model(scene_of("minimal"));
  State start(model);
  start.q[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(SplitGrasp(model, start), std::runtime_error);
}

TEST(Threads, HoldABoxWithoutLosingARecord) {
  const Model model(split_scene());
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
  const Model model(scene_of("minimal"));
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

TEST(Threads, EndWhenTheReceiverThrows) {
  const Model model(scene_of("minimal"));
  State state(model);
  const std::vector<int> cores = allowed_cores();
  ThreadSettings settings;
  settings.duration_s = 60.0;
  settings.on_tick = [](const ContactSample&) -> bool { throw std::runtime_error("enough"); };
  EXPECT_THROW(run_threads(model, state, settings), std::runtime_error);
  EXPECT_EQ(allowed_cores(), cores);
}

TEST(Threads, DoNotStartWithoutGraspForces) {
  // Without friction the fingers' normals, all along the grip axis, cannot carry the weight across it.
  const Model model(scene_of("box_grasp", {kCoarseBox, "control.grasp.friction=0"}));
  State state(model);
  ThreadSettings settings;
  settings.duration_s = 60.0;
  const ThreadsReport report = run_threads(model, state, settings);
  EXPECT_NE(report.first_control.grasp, GraspStatus::kOptimal);
  EXPECT_EQ(report.ticks, 0);
  EXPECT_EQ(state.tick, 0);
}

/// What a run's records go through, with room for a whole test: so the copy and the push of each are under test as well.
using Ring = boost::lockfree::spsc_queue<ContactSample, boost::lockfree::capacity<1024>>;

// In the thread of the loop itself, beside a control thread that keeps frames coming.
TEST(Threads, ContactLoopTakesNoMemory) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  const Model model(split_scene());
  SplitGrasp grasp(model);
  const auto ring = std::make_unique<Ring>();
  std::int64_t handed_over = 0;
  const std::function<bool(const ContactSample&)> keep = [&](const ContactSample& sample) {
    if (sample.step.tick.handed_over) ++handed_over;
    return ring->push(sample);
  };
  const std::jthread control = control_thread(grasp, model.scene.control_period_s);
  const std::stop_token never;
  const AllocationCounter counter;
  const ContactLoopCounts counts =
      run_contact_loop(grasp, Schedule(steady_now_ns() + 1'000'000, model.scene.step_s, 500, 2), 50'000, keep, never);
  EXPECT_EQ(counter.count(), 0);
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
  std::int64_t ticks = 0, handed_over = 0, lost = -1;
  double denormal_product = -1.0;
};

/// Runs a contact loop of 600 ticks at 1 kHz under the trap, then breaks its rules on purpose. Ends the process.
[[noreturn]] void run_trapped(const Model& model, TrapResult& result) {
  SplitGrasp grasp(model);
  const auto ring = std::make_unique<Ring>();
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
    const ContactLoopCounts counts = run_contact_loop(grasp, schedule, 50'000, keep, never);
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
  const Model model(split_scene());
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
  EXPECT_EQ(result.denormal_product, 0.0);
  // The trap does catch: a write, and memory from the system.
  EXPECT_EQ(result.after_write, result.violations + 1);
  EXPECT_GT(result.after_large_block, result.after_write);
  munmap(page, sizeof(TrapResult));
}

}  // namespace
}  // namespace thenar
