#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "engine/grasp_monitor.h"
#include "engine/monolithic.h"
#include "engine/verdict.h"
#include "tests/scenes.h"

namespace thenar {
namespace {

/// A run of 0.5 s in steps of 1 ms in which nothing happens, every finger loaded by force_N(tick).
template <typename Force>
Recording steady_run(Force force_N) {
  Recording recording;
  for (int i = 0; i < 500; ++i) {
    TickRecord tick;
    tick.desired_N.fill(Eigen::Vector3d::Zero());
    tick.time_s = 1e-3 * (i + 1);
    tick.position_m = tick.target_m = Eigen::Vector3d::Zero();
    for (auto& force : tick.force) force.normal_N = force_N(i);
    recording.ticks.push_back(tick);
  }
  return recording;
}

const Model& minimal() {
  static const Model model(scene_of("minimal"));
  return model;
}

Outcome outcome(const Recording& recording) { return verdict(minimal(), recording).outcome; }

TEST(ForceChatter, OfAnAlternatingForceIsTwiceItsAmplitude) {
  // The window has one tick more on one side of the mean.
  const double share = force_chatter(steady_run([](int i) { return i % 2 == 0 ? 3.3 : 2.7; }));
  EXPECT_NEAR(share, 2.0 * 0.3 / 3.0, 0.2 / 300.0);
}

TEST(ForceChatter, IsNoneOnARampAndNextToNoneOfAJump) {
  EXPECT_LT(force_chatter(steady_run([](int i) { return 1.0 + 1e-3 * i; })), 1e-12);
  // A jump by a force's whole size: two second differences of it, halved, among 300 ticks of the mean 1.5.
  EXPECT_NEAR(force_chatter(steady_run([](int i) { return i < 350 ? 1.0 : 2.0; })), 1.0 / 300.0 / 1.5, 1e-4);
}

// A loop that swings with the age of its frames, ten ticks: from tick to tick it is smooth.
TEST(ForceChatter, SeesASwingFromFrameToFrame) {
  Recording swing = steady_run([](int i) { return 3.0 + 0.3 * std::sin(std::numbers::pi * i / 10.0); });
  const double unseen = force_chatter(swing);
  for (std::size_t i = 0; i < swing.ticks.size(); ++i) swing.ticks[i].contact.frame_age = static_cast<long>(i % 10);
  // Half a period on, a sine is its negative: the mean of 2 |0.3 sin| over ten ticks, over 3; the window has one tick
  // more.
  const double mean_sine = 0.1 / std::tan(std::numbers::pi / 20.0);
  EXPECT_NEAR(force_chatter(swing) / (2.0 * 0.3 / 3.0 * mean_sine), 1.0, 1.0 / 300.0);
  EXPECT_LT(unseen, 0.05 * force_chatter(swing));
}

TEST(ForceChatter, IsNotANumberWithoutLoad) {
  EXPECT_TRUE(std::isnan(force_chatter(steady_run([](int) { return 0.0; }))));
  EXPECT_TRUE(std::isnan(force_chatter({})));
}

TEST(Verdict, TellsWhatBecameOfARun) {
  const auto load = [](int) { return 2.0; };
  EXPECT_EQ(outcome(steady_run(load)), Outcome::kHeld);
  EXPECT_EQ(outcome(steady_run([](int i) { return i % 2 == 0 ? 2.1 : 1.9; })), Outcome::kUnstable);

  Recording run = steady_run(load);
  run.ticks.back().slip_m[1] = 2.0 * kNoticedSlip_m;
  EXPECT_EQ(outcome(run), Outcome::kSlipping);
  run = steady_run(load);
  run.ticks[400].force[2].normal_N = 0.0;
  EXPECT_EQ(outcome(run), Outcome::kSlipping);
  run.ticks[400].force[2].normal_N = 2.0;
  run.ticks[400].contact.solve.status = SolveStatus::kNotFinite;
  EXPECT_EQ(outcome(run), Outcome::kSolverFailed);
  run = steady_run(load);
  for (std::size_t i = 100; i < 200; ++i) {
    run.ticks[i].contact.contacts = 3;
    run.ticks[i].contact.solve.residual = 0.1;
  }
  EXPECT_EQ(outcome(run), Outcome::kSolverFailed);
}

// What came first is the cause: forces that cannot be found because a finger slid are not the solver's fault.
TEST(Verdict, NamesWhatCameFirst) {
  Recording run = steady_run([](int) { return 2.0; });
  run.ticks[300].muscle = MuscleStatus::kInfeasible;
  run.loss = Loss{0.5, 0.2, LossCause::kSlipped, "the thumb slipped"};
  EXPECT_EQ(outcome(run), Outcome::kSlipping);
  run.loss->since_s = 0.4;
  EXPECT_EQ(outcome(run), Outcome::kSolverFailed);
  run.ticks[300].muscle = MuscleStatus::kOptimal;
  EXPECT_EQ(outcome(run), Outcome::kSlipping);
  run.loss->cause = LossCause::kOffTarget;
  EXPECT_EQ(outcome(run), Outcome::kOffTarget);
}

// Forces chatter by 10 % from the tick 200 on: the mean of |second difference| / 2 is twice the amplitude of 5 %.
TEST(Verdict, ChatterCountsUpToWhatCameFirst) {
  const auto late_chatter = [] { return steady_run([](int i) { return i < 200 ? 2.0 : i % 2 == 0 ? 2.1 : 1.9; }); };
  EXPECT_EQ(outcome(late_chatter()), Outcome::kUnstable);
  Recording run = late_chatter();
  run.ticks[150].muscle = MuscleStatus::kInfeasible;
  EXPECT_EQ(outcome(run), Outcome::kSolverFailed);
  run = late_chatter();
  run.ticks[450].muscle = MuscleStatus::kInfeasible;
  EXPECT_EQ(outcome(run), Outcome::kUnstable);
  run.loss = Loss{0.5, 0.15, LossCause::kSlipped, "the thumb slipped"};
  EXPECT_EQ(outcome(run), Outcome::kSlipping);
  run.loss->since_s = 0.4;
  EXPECT_EQ(outcome(run), Outcome::kUnstable);
}

// 1.5 % is more than a steady grip has, but not clearly the cause of a slip that follows.
TEST(Verdict, ChatterAtTheThresholdIsNotTheCauseOfASlip) {
  Recording run = steady_run([](int i) { return 2.0 + (i % 2 == 0 ? 0.015 : -0.015); });
  EXPECT_EQ(outcome(run), Outcome::kUnstable);
  run.loss = Loss{0.5, 0.45, LossCause::kSlipped, "the thumb slipped"};
  EXPECT_EQ(outcome(run), Outcome::kSlipping);
}

TEST(Verdict, EveryOutcomeButHeldHasAReason) {
  for (const auto& [overrides, expected] : {std::pair<std::string, Outcome>{"time.duration=0.6 s", Outcome::kHeld},
                                            {"contact.friction=0.2", Outcome::kSlipping},
                                            {"control.gain=400 N*m/rad", Outcome::kUnstable},
                                            {"control.grasp.friction=0", Outcome::kSolverFailed}}) {
    const Model model(scene_of("box_grasp", {kCoarseBox, overrides}));
    State state(model);
    const Verdict judged = verdict(model, run_monolithic(model, state));
    EXPECT_EQ(judged.outcome, expected) << overrides << ": " << judged.reason;
    EXPECT_EQ(judged.reason.empty(), judged.outcome == Outcome::kHeld) << judged.reason;
  }
}

// A position that is not a number passes no comparison: it must not pass for one that is near.
TEST(GraspMonitor, LosesWhatIsNotANumber) {
  GraspMonitor monitor(minimal().scene.hand);
  TickRecord tick = steady_run([](int) { return 2.0; }).ticks.front();
  EXPECT_FALSE(monitor.update(1e-3, tick));
  tick.position_m[1] = std::numeric_limits<double>::quiet_NaN();
  const auto loss = monitor.update(1e-3, tick);
  ASSERT_TRUE(loss);
  EXPECT_EQ(loss->cause, LossCause::kOffTarget);
}

}  // namespace
}  // namespace thenar
