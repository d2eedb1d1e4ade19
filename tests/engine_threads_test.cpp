#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
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

#include "engine/carry_over.h"
#include "engine/live_contact.h"
#include "engine/lockstep.h"
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

/// Both loops on one thread, from the grasp's tick to another.
void run(SplitGrasp& grasp, std::int64_t end) {
  while (grasp.state().tick < end) {
    if (grasp.state().tick > 0 && grasp.model().control_is_due(grasp.state().tick)) grasp.control_step();
    grasp.contact_step();
  }
}

TEST(SplitGrasp, GoesOnAsItWasWhereNothingHasChanged) {
  const Model model(split_scene());
  SplitGrasp grasp(model), same(model);
  run(grasp, 150);
  run(same, 150);
  grasp.heed_scene();
  grasp.hold_frames_back(0);
  run(grasp, 300);
  run(same, 300);
  EXPECT_EQ(grasp.state().q, same.state().q);
  EXPECT_EQ(grasp.state().X_WO.matrix(), same.state().X_WO.matrix());
  EXPECT_EQ(grasp.controller().f_desired, same.controller().f_desired);

  // Nor does a state carried over to an equal model change.
  const State carried = carry_over(model, grasp.state(), Model(model));
  EXPECT_EQ(carried.tick, 300);
  EXPECT_EQ(carried.u_m, grasp.state().u_m);
  ASSERT_EQ(carried.forces.size(), grasp.state().forces.size());
  for (std::size_t i = 0; i < carried.forces.size(); ++i) {
    EXPECT_EQ(carried.forces[i].control_point, grasp.state().forces[i].control_point);
    EXPECT_EQ(carried.forces[i].f_C, grasp.state().forces[i].f_C);
  }
  for (int k = 0; k < kFingers; ++k) EXPECT_EQ(carried.load[k].force_N, grasp.state().load[k].force_N);
}

// Held back by the runner or on a channel's way, frames come into use at the same time: to the last bit.
TEST(SplitGrasp, HoldsFramesBackAsADelayDoes) {
  Scene scene = split_scene();
  scene.control_delay_s = 3.0 * scene.control_period_s;
  const Model model(scene);
  SplitGrasp grasp(model);
  grasp.hold_frames_back(3);
  Lockstep delayed(model);
  for (int tick = 0; tick < 300; ++tick) {
    if (tick > 0 && model.control_is_due(tick)) grasp.control_step();
    const ContactStep step = grasp.contact_step();
    const TickReport report = delayed.tick();
    ASSERT_EQ(step.tick.sequence, report.sequence) << tick;
    ASSERT_FALSE(step.tick.held) << tick;
    ASSERT_EQ(grasp.state().q, delayed.state.q) << tick;
  }
  EXPECT_GT(grasp.state().load[0].normal_N, 0.5);
  EXPECT_EQ(grasp.frames().counts().unaccounted(), 0);
  // With less delay the newest on its way comes into use at once, and nothing is held.
  grasp.hold_frames_back(2);
  EXPECT_FALSE(grasp.contact_step().tick.held);
  // And without a delay the newest is there at once.
  grasp.hold_frames_back(0);
  const std::int64_t newest = grasp.control_step().sequence;
  EXPECT_EQ(grasp.contact_step().tick.sequence, newest);
}

TEST(SplitGrasp, LosesWhatLessFrictionCannotHold) {
  const auto most_slip_m = [](double friction) {
    Model model(split_scene());  // carried sideways from 0.4 to 1.2 s
    SplitGrasp grasp(model);
    run(grasp, 350);
    model.scene.contact.friction = friction;
    grasp.heed_scene();
    std::array<double, kFingers> slip_m{};
    while (grasp.state().tick < 1200) {
      if (model.control_is_due(grasp.state().tick)) grasp.control_step();
      const TickReport tick = grasp.contact_step().tick;
      for (int k = 0; k < kFingers; ++k) slip_m[k] += tick.slip_m[k];
    }
    return *std::max_element(slip_m.begin(), slip_m.end());
  };
  EXPECT_LT(most_slip_m(0.8), 0.05e-3);
  EXPECT_GT(most_slip_m(0.2), 2e-3);  // lost, says the monitor
}

/// Other fingertips or another step for a running grasp.
struct Change {
  const char* name;
  PulpKernel kernel;
  int level;
  double step_s;
};

class ChangedGrasp : public testing::TestWithParam<Change> {};

// Time, pose and grip go on, and the box stays where it is held.
TEST_P(ChangedGrasp, HoldsTheBox) {
  Scene scene = split_scene();
  scene.task = {};
  Model model(scene);
  auto grasp = std::make_unique<SplitGrasp>(model);
  run(*grasp, 500);
  const State before = grasp->state();
  const std::int64_t sequence = grasp->controller().sequence;
  const Model old = model;
  model.scene.step_s = GetParam().step_s;
  model.set_fingertips(GetParam().kernel, GetParam().level);
  grasp = std::make_unique<SplitGrasp>(model, old, *grasp);
  EXPECT_EQ(grasp->first_control().grasp, GraspStatus::kOptimal);
  EXPECT_EQ(grasp->controller().sequence, sequence + 1);
  EXPECT_NEAR(static_cast<double>(grasp->state().tick) * model.scene.step_s, 0.5, 1e-9);
  EXPECT_EQ(grasp->state().q, before.q);

  double way_m = 0.0, force_N = 0.0;
  const auto end = static_cast<std::int64_t>(std::lround(1.0 / model.scene.step_s));
  while (grasp->state().tick < end) {
    run(*grasp, grasp->state().tick + 1);
    way_m = std::max(way_m, (grasp->state().X_WO.translation() - before.X_WO.translation()).norm());
    force_N = std::max(force_N, grasp->state().load[0].force_N.norm());
    ASSERT_TRUE(is_finite(grasp->state()));
    ASSERT_FALSE(grasp->state().held);
  }
  // A pulp with other control points is pressed in otherwise: by some of the depth of the press, 1 mm.
  EXPECT_LT(way_m, 0.25e-3);
  EXPECT_LT(force_N, 1.5 * before.load[0].force_N.norm());
  EXPECT_LT((model.target(1.0).translation() - grasp->state().X_WO.translation()).norm(), 0.1e-3);
  for (int k = 0; k < kFingers; ++k) {
    EXPECT_NEAR(grasp->state().load[k].normal_N, before.load[k].normal_N, 0.1 * before.load[k].normal_N) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(SplitGrasp, ChangedGrasp,
                         testing::Values(Change{"Nothing", PulpKernel::kBoussinesq, 0, 1e-3},
                                         Change{"Coarse", PulpKernel::kBoussinesq, 2, 1e-3},
                                         Change{"Gaussian", PulpKernel::kGaussian, 0, 1e-3},
                                         Change{"CoarseGaussian", PulpKernel::kGaussian, 3, 1e-3},
                                         Change{"FasterContact", PulpKernel::kBoussinesq, 0, 0.25e-3},
                                         Change{"SlowerContact", PulpKernel::kBoussinesq, 0, 5e-3}),
                         [](const auto& change) { return std::string(change.param.name); });

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

TEST(Threads, GoOnWithTheSameGraspAndAtAnotherSpeed) {
  const Model model(split_scene());
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
  const Model model(split_scene());
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

/// What a run's records go through, with room for a whole test: so the copy and the push of each are under test as well.
using Ring = boost::lockfree::spsc_queue<ContactSample, boost::lockfree::capacity<1024>>;

// In the thread of the loop itself, beside a control thread that keeps frames coming.
TEST(Threads, ContactLoopTakesNoMemory) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  const Model model(split_scene());
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
  EXPECT_GT(result.pictures, 1);
  EXPECT_EQ(result.denormal_product, 0.0);
  // The trap does catch: a write, and memory from the system.
  EXPECT_EQ(result.after_write, result.violations + 1);
  EXPECT_GT(result.after_large_block, result.after_write);
  munmap(page, sizeof(TrapResult));
}

}  // namespace
}  // namespace thenar
