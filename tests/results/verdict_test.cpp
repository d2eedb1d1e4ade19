// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/results/grasp_monitor.h"
#include "engine/results/scene_run.h"
#include "engine/sweeps/sweep.h"
#include "tests/results/watched_runs.h"
#include "tests/support/scenes.h"

namespace thenar::verdict_test {
namespace {

using namespace watched_runs;

TEST(Verdict, TellsWhatBecameOfARun) {
  EXPECT_EQ(in_words(steady_run().verdict()), "held");
  EXPECT_EQ(steady_run([](int i) { return i % 2 == 0 ? 2.1 : 1.9; }).outcome(), Outcome::kUnstable);

  Watched run = steady_run();
  run.slip(400, 1, 2.0 * kSlipping_m);
  EXPECT_EQ(in_words(run.verdict()), "slipping: the index slipped 0.20 mm from 0.401 s on");
  run = steady_run();
  run.ticks[400].force[2].normal_N = 0.0;
  EXPECT_EQ(in_words(run.verdict()), "slipping: the major carried no load at 0.401 s");
  run = steady_run();
  run.ticks[400].contact.solve.status = SolveStatus::kNotFinite;
  EXPECT_EQ(run.outcome(), Outcome::kSolverFailed);
  run = steady_run();
  for (TickRecord& tick : run.ticks) {
    tick.contact.contacts = 3;
    tick.contact.solve.residual = 1e-7;
  }
  for (std::size_t i = 100; i < 105; ++i) run.ticks[i].contact.solve.residual = 0.1;
  EXPECT_EQ(run.outcome(), Outcome::kHeld) << "one in a hundred";
  run.ticks[105].contact.solve.residual = 0.1;
  EXPECT_EQ(run.outcome(), Outcome::kSolverFailed);
}

// Ways add up as vectors: a patch that goes to and fro stays, one that goes on in small steps slips, though it never
// slides as a whole. What slid as a whole is told as that; a scene that names how far is lost tolerates less.
TEST(Verdict, APatchThatWalksSlips) {
  using Eigen::Vector3d;
  const double most_m = kWalks * minimal().scene.hand.fingertips[0].radius_m;
  Watched run = steady_run();
  for (std::size_t i = 310; i + 10 < 500; i += 20) {
    run.walk(i, 0, Vector3d(0.0, 0.9 * most_m, 0.0), 0.1);
    run.walk(i + 10, 0, Vector3d(0.0, -0.9 * most_m, 0.0), -0.1);
  }
  EXPECT_EQ(in_words(run.verdict()), "held");
  // The third of ten steps is beyond; the farthest place is beside that of the way to and fro.
  for (std::size_t i = 400; i < 410; ++i) run.walk(i, 0, Vector3d(0.4 * most_m, 0.0, 0.0), 2.0 / kDegrees);
  ASSERT_NEAR(most_m, 0.63e-3, 1e-12);
  EXPECT_EQ(in_words(run.verdict()),
            "slipping: the thumb's patch walked 2.58 mm net and turned by 26 degrees, in turns, from 0.403 s on");

  run.slip(420, 0, 2.0 * kSlipping_m);
  EXPECT_EQ(in_words(run.verdict()), "slipping: the thumb slipped 0.20 mm from 0.421 s on");
  run = steady_run();
  run.walk(350, 2, Vector3d(0.0, 0.0, 1.01 * most_m));
  EXPECT_EQ(run.outcome(), Outcome::kSlipping);
  Scene scene = minimal().scene;
  scene.task.lost_m = 2e-3;
  EXPECT_EQ(run.verdict(build_model(scene, minimal())).outcome, Outcome::kHeld);
  // Before the fingers hold the object they may walk on it.
  for (std::size_t i = 0; i < 400; ++i) run.ticks[i].holds = false;
  EXPECT_EQ(run.outcome(), Outcome::kHeld);
}

// A run that goes on after the loss keeps the story of one that ends there.
TEST(Verdict, StaysAsItWasAtTheEnd) {
  Watched run = steady_run();
  run.slip(400, 0, 1.1 * minimal().scene.hand.fingertips[0].radius_m);
  Watched ended = run;
  ended.ticks.resize(401);
  run.ticks[420].contact.solve.status = SolveStatus::kNotFinite;
  run.ticks[420].target_m.x() = 0.1;
  run.unsolved_muscles(0.43);
  EXPECT_EQ(run.outcome(), Outcome::kLost);
  EXPECT_EQ(in_words(run.verdict()), in_words(ended.verdict()));
}

// A target that runs away is not a hand that lets go, nor the other way round.
TEST(Verdict, OffTargetIsNotLost) {
  Watched run = steady_run();
  for (std::size_t i = 200; i < 300; ++i) run.ticks[i].target_m.x() = 12e-3;
  run.ticks[250].target_m.x() = 14e-3;
  Verdict verdict = run.verdict();
  EXPECT_EQ(verdict.outcome, Outcome::kOffTarget);
  EXPECT_FALSE(verdict.lost_s);
  EXPECT_EQ(verdict.reason, "the object was 14.0 mm off its target at 0.251 s (more than 10 mm from 0.201 s on)");
  run = steady_run();
  run.ticks[300].rotation_error_rad = 0.4;
  EXPECT_EQ(run.outcome(), Outcome::kOffTarget);

  // Two fingers open for 50 ms and a little more.
  const auto opened = [](std::size_t ticks) {
    Watched opens = steady_run();
    for (std::size_t i = 200; i < 200 + ticks; ++i)
      opens.ticks[i].force[1].normal_N = opens.ticks[i].force[2].normal_N = 0.0;
    return opens.verdict();
  };
  EXPECT_EQ(opened(49).outcome, Outcome::kSlipping);
  verdict = opened(52);
  EXPECT_EQ(verdict.outcome, Outcome::kLost);
  EXPECT_NEAR(verdict.lost_s.value_or(0.0), 0.251, 1.5e-3);
  // A finger that has slid by its radius is somewhere else.
  run = steady_run();
  run.slip(400, 0, 1.1 * minimal().scene.hand.fingertips[0].radius_m);
  EXPECT_EQ(run.outcome(), Outcome::kLost);
  run.ticks.resize(400);
  EXPECT_EQ(run.outcome(), Outcome::kHeld);
}

// Without a controller nobody has asked for a target, or for three fingers; but what falls is lost.
TEST(Verdict, IsAsTrueWithoutAController) {
  Scene scene = minimal().scene;
  scene.control.reset();
  scene.torques = scene.hand.at_zero();
  const Model model = build_model(scene, minimal());
  Watched run = steady_run();
  for (TickRecord& tick : run.ticks) {
    tick.target_m.x() = 1.0;
    tick.force[2].normal_N = 0.0;
  }
  EXPECT_EQ(in_words(run.verdict(model)), "held");
  for (TickRecord& tick : run.ticks) tick.force[1].normal_N = 0.0;
  EXPECT_EQ(run.verdict(model).outcome, Outcome::kLost);
  EXPECT_FALSE(fails(scene, Outcome::kLost));
  EXPECT_TRUE(fails(scene, Outcome::kSolverFailed));
  EXPECT_TRUE(fails(minimal().scene, Outcome::kLost));
  // What a spring carries, the hand cannot lose.
  scene.task.spring = Spring{1.0, 1.0};
  EXPECT_EQ(run.verdict(build_model(scene, minimal())).outcome, Outcome::kHeld);
}

TEST(Verdict, SaysWhichLimitByHowMuchAndWhen) {
  Watched run = steady_run();
  const Joint& joint = minimal().scene.hand.joints[3];
  for (TickRecord& tick : run.ticks) tick.q_rad = minimal().scene.posture;
  for (std::size_t i = 100; i < 200; ++i) run.ticks[i].q_rad[3] = joint.upper_rad + 0.01;
  run.ticks[150].q_rad[3] = joint.upper_rad + 0.02;
  run.ticks[450].q_rad[5] = minimal().scene.hand.joints[5].lower_rad - 0.001;
  const Verdict verdict = run.verdict();
  EXPECT_EQ(verdict.outcome, Outcome::kOverLimits);
  ASSERT_EQ(verdict.beyond.size(), 2U);
  EXPECT_EQ(verdict.beyond[0].name, joint.name);
  EXPECT_EQ(verdict.beyond[0].limit, joint.upper_rad);
  EXPECT_NEAR(verdict.beyond[0].value - joint.upper_rad, 0.02, 1e-12);
  EXPECT_NEAR(verdict.beyond[0].at_s, 0.151, 1e-12);
  EXPECT_NEAR(verdict.beyond[0].first_s, 0.101, 1e-12);
  EXPECT_NE(verdict.reason.find("the joint T_IP_FE was 0.0200 rad past its limit of 1.309 rad at 0.151 s"),
            std::string::npos)
      << verdict.reason;
  EXPECT_NE(verdict.reason.find("the joint I_MCP_AA was 0.0010 rad"), std::string::npos) << verdict.reason;
  EXPECT_TRUE(fails(minimal().scene, verdict.outcome));
}

TEST(Verdict, SaysWhichMuscleIsAskedForMoreThanItHas) {
  const Model model = build_model(scene_of("box_grasp", {kCoarseBox}));
  GraspMonitor monitor(model);
  Eigen::VectorXd forces_N = Eigen::VectorXd::Zero(23);
  monitor.add(0.0, solved(), forces_N);
  EXPECT_TRUE(monitor.verdict().beyond.empty());
  const Muscle& muscle = model.scene.hand.muscles[4];
  forces_N[4] = 2.0 * muscle.max_force_N;
  monitor.add(0.1, solved(), forces_N);
  forces_N[4] = 3.0 * muscle.max_force_N;
  monitor.add(0.2, solved(), forces_N);
  const Verdict verdict = monitor.verdict();
  EXPECT_EQ(verdict.outcome, Outcome::kOverLimits);
  EXPECT_EQ(verdict.reason, "the muscle FPL would need 603 N at 0.200 s, 3 times its 201 N (first passed at 0.100 s)");
}

// Forces that cannot be found because a finger slid are not the solver's fault.
TEST(Verdict, NamesTheCause) {
  Watched run = steady_run();
  run.slip(350, 0, 1e-3);
  run.unsolved_muscles(0.3);
  EXPECT_EQ(run.outcome(), Outcome::kSolverFailed);
  run.controls.clear();
  run.unsolved_muscles(0.4);
  const Verdict verdict = run.verdict();
  EXPECT_EQ(verdict.outcome, Outcome::kSlipping);
  EXPECT_NE(verdict.reason.find("no muscle forces give the torques wanted at 0.400 s"), std::string::npos)
      << "the rest is told, too: " << verdict.reason;
}

// The grasp as a user meets it: each word from a run of its own, by both ways to run it, which agree.
TEST(Verdict, IsOneForRunAndSweepAndEveryOutcomeButHeldHasAReason) {
  for (const auto& [overrides, expected] :
       {std::pair<std::vector<std::string>, Outcome>{{"time.duration=0.6 s"}, Outcome::kHeld},
        {{"contact.friction=0.3", "time.duration=1.2 s"}, Outcome::kSlipping},
        {{"contact.friction=0.2", "time.duration=1.2 s"}, Outcome::kLost},
        {{"contact.friction=0.05", "time.duration=0.3 s"}, Outcome::kLost},  // before its grip has built up
        {{"control.gain=170 N*m/rad", "time.duration=0.6 s"}, Outcome::kUnstable},
        {{"control.grasp.friction=0"}, Outcome::kSolverFailed},
        {{"control.grasp.internal_force=12 N", "time.duration=0.6 s"}, Outcome::kOverLimits},
        // A joint meets the end of its range, and the finger stays behind.
        {{"task.translate.by=[0 mm, 40 mm, 0 mm]", "time.duration=1.1 s"}, Outcome::kLost},
        {{"task.translate.over=50 ms", "time.duration=0.6 s"}, Outcome::kOffTarget}}) {
    std::vector<std::string> all{kCoarseBox, "contact.level=2"};
    all.insert(all.end(), overrides.begin(), overrides.end());
    const Model model = build_model(scene_of("box_grasp", all));
    State state(model);
    const Recording recording = run_scene(model, state);
    const Verdict& verdict = recording.verdict;
    EXPECT_EQ(verdict.outcome, expected) << overrides.front() << ": " << in_words(verdict);
    EXPECT_EQ(verdict.reason.empty(), verdict.outcome == Outcome::kHeld) << verdict.reason;
    const SweepRow row = run_row(model);
    EXPECT_EQ(in_words(row.verdict), in_words(verdict));
    // What is lost is lost; all else is let go on.
    EXPECT_EQ(recording.stopped, expected == Outcome::kLost || expected == Outcome::kSolverFailed) << overrides.front();
  }
}

TEST(Verdict, ABoxThatNobodyHoldsIsLostThoughNothingFails) {
  Scene scene = scene_of("box_grasp", {kCoarseBox, "contact.level=2", "time.duration=1 s"});
  scene.control.reset();
  scene.torques = scene.hand.at_zero();
  const Model model = build_model(scene);
  const SweepRow row = run_row(model);
  EXPECT_EQ(row.verdict.outcome, Outcome::kLost) << in_words(row.verdict);
  EXPECT_FALSE(fails(scene, row.verdict.outcome));
}

}  // namespace
}  // namespace thenar::verdict_test
