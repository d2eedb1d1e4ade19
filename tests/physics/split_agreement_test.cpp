// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "engine/control/control.h"
#include "engine/loops/run.h"
#include "engine/loops/threads.h"
#include "engine/models/build_model.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::split_agreement_test {
namespace {

/// Other processes that want every core of the machine all the time.
class Load {
 public:
  Load() {
    for (unsigned i = 0; i < std::thread::hardware_concurrency(); ++i) {
      const pid_t child = fork();
      if (child == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);  // never longer than the test
        for (std::atomic<unsigned> busy = 0;;) ++busy;
      }
      if (child > 0) children_.push_back(child);
    }
  }
  ~Load() {
    for (const pid_t child : children_) {
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
    }
  }
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

 private:
  std::vector<pid_t> children_;
};

/// A box that is carried 10 mm and then held long enough for the path there to be forgotten.
Scene carried_box() {
  return scene_of("box_grasp", {kCoarseBox, "time.control_period=5 ms", "time.duration=2 s",
                                "task.translate.by=[0 mm, 10 mm, 0 mm]", "task.translate.from=0.2 s"});
}

/// How a run ended, as far as anybody can see.
struct Ending {
  Snapshot state;
  bool lost = false;
  std::int64_t last_hold = 0;  ///< The last tick on the drive of an old frame.
};

/// Far off its target: what the grasp monitor calls lost. (Its slips are the contact ticks' own affair.)
bool is_lost(const Model& model, const Snapshot& state) {
  const double time_s = static_cast<double>(state.tick) * model.scene.step_s;
  return pose_error(model.target(time_s), state.X_WO).head<3>().norm() > 10e-3;
}

Ending lockstep_ending(const Model& model) {
  GraspRun loops(model, LockstepSettings{});
  Ending ending;
  while (loops.state.tick < 2000) {
    loops.tick();
    ending.lost = ending.lost || is_lost(model, loops.state);
  }
  ending.state = loops.state;
  return ending;
}

Ending threaded_ending(const Model& model, bool realtime, ThreadsReport& report) {
  State state(model);
  Ending ending;
  ThreadSettings settings;
  settings.duration_s = model.scene.duration_s;
  settings.realtime = realtime;
  settings.on_tick = [&](const ContactSample& sample) {
    ending.lost = ending.lost || is_lost(model, sample.after);
    if (sample.after.held) ending.last_hold = sample.after.tick;
    return true;
  };
  report = run_threads(model, state, settings);
  ending.state = state;
  return ending;
}

// Chance decides when the threads' frames come, and so, by micrometres, what path the object takes. Where it ends does
// not depend on it: the controller's integrals have settled 1 s after the move, to some 10 um (their time constant is
// 0.3 s), and the forces with them, but for what friction keeps of the path: 2 %. Ticks that slip leave time to settle
// out: no more than a quarter may. During a hold nothing controls the object, which needs that time, too: none may be
// in the last second.
void expect_agreement(bool realtime, int repetitions) {
  const Model model = build_model(carried_box());
  const Ending expected = lockstep_ending(model);
  ASSERT_FALSE(expected.lost);
  int compared = 0;
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    SCOPED_TRACE(repetition);
    ThreadsReport report;
    const Ending ending = threaded_ending(model, realtime, report);
    SCOPED_TRACE(testing::Message() << report.contact.policy << ", slipped " << report.slipped);
    EXPECT_EQ(report.ticks + report.slipped, 2000);
    EXPECT_EQ(report.frames.torn + report.snapshots.torn, 0);
    EXPECT_EQ(report.frames.unaccounted() + report.snapshots.unaccounted(), 0);
    EXPECT_FALSE(ending.lost);
    if (report.slipped > 500 || ending.last_hold > 1000) continue;  // the counts above hold all the same
    ++compared;
    const auto error = pose_error(expected.state.X_WO, ending.state.X_WO);
    EXPECT_LE(error.head<3>().norm(), 0.1e-3);
    EXPECT_LE(error.tail<3>().norm(), 0.1 * EIGEN_PI / 180.0);
    for (int k = 0; k < kFingers; ++k) {
      EXPECT_NEAR(ending.state.load[k].normal_N / expected.state.load[k].normal_N, 1.0, 0.02);
    }
  }
  if (compared == 0) GTEST_SKIP() << "this machine gave ticks or frames too little time";
}

TEST(SplitAgreement, ThreadsEndWhereLockstepDoes) { expect_agreement(true, 3); }

TEST(SplitAgreement, ThreadsEndWhereLockstepDoesOnALoadedMachine) {
  const Load load;
  expect_agreement(true, 2);
}

TEST(SplitAgreement, ThreadsEndWhereLockstepDoesOnALoadedMachineWithoutRealTimeRights) {
  const Load load;
  expect_agreement(false, 2);
}

}  // namespace
}  // namespace thenar::split_agreement_test
