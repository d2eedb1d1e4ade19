// SPDX-License-Identifier: Apache-2.0
#include "engine/results/grasp_monitor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "engine/models/build_model.h"
#include "tests/results/watched_runs.h"
#include "tests/support/scenes.h"

namespace thenar::grasp_monitor_test {
namespace {

using namespace watched_runs;

double force_chatter(const Watched& run) { return run.verdict().force_chatter; }

TEST(ForceChatter, OfAnAlternatingForceIsTwiceItsAmplitude) {
  // The window has one tick more on one side of the mean.
  const double share = force_chatter(steady_run([](int i) { return i % 2 == 0 ? 3.3 : 2.7; }));
  EXPECT_NEAR(share, 2.0 * 0.3 / 3.0, 0.2 / 300.0);
}

TEST(ForceChatter, IsNoneOnARampAndNextToNoneOfAJump) {
  EXPECT_LT(force_chatter(steady_run([](int i) { return 1.0 + 1e-3 * i; })), 1e-12);
  // A jump by a force's whole size: two second differences of it, halved, among the 200 ticks from 0.3 s on, whose mean
  // is 1.75.
  EXPECT_NEAR(force_chatter(steady_run([](int i) { return i < 350 ? 1.0 : 2.0; })), 1.0 / 200.0 / 1.75, 1e-4);
}

// A loop that swings with the age of its frames, ten ticks: from tick to tick it is smooth.
TEST(ForceChatter, SeesASwingFromFrameToFrame) {
  Watched swing = steady_run([](int i) { return 3.0 + 0.3 * std::sin(std::numbers::pi * i / 10.0); });
  const Model model = build_model(scene_of("minimal", {"time.control_period=10 ms"}));
  const double unseen = swing.verdict(model).force_chatter;
  for (std::size_t i = 0; i < swing.ticks.size(); ++i) swing.ticks[i].contact.frame_age = static_cast<long>(i % 10);
  // Half a period on, a sine is its negative: the mean of 2 |0.3 sin| over ten ticks, over 3; the window has one tick
  // more.
  const double mean_sine = 0.1 / std::tan(std::numbers::pi / 20.0);
  const double seen = swing.verdict(model).force_chatter;
  EXPECT_NEAR(seen / (2.0 * 0.3 / 3.0 * mean_sine), 1.0, 1.0 / 300.0);
  EXPECT_LT(unseen, 0.05 * seen);
}

TEST(ForceChatter, IsNotANumberWithoutLoad) {
  EXPECT_TRUE(std::isnan(force_chatter(steady_run([](int) { return 0.0; }))));
  EXPECT_TRUE(std::isnan(force_chatter(Watched{})));
}

// How the grip builds up is told apart from what it does then.
TEST(Verdict, CountsSlipFromTheEndOfTheStart) {
  Watched run = steady_run();
  run.slip(100, 0, 1e-3);
  EXPECT_EQ(run.outcome(), Outcome::kHeld);
  run.slip(350, 0, 0.9 * kSlipping_m);
  EXPECT_EQ(run.outcome(), Outcome::kHeld);
  run.slip(360, 0, 0.2 * kSlipping_m);
  EXPECT_EQ(run.outcome(), Outcome::kSlipping);
}

// A patch that turns where it is slides at its rim: that is told, and is no slip.
TEST(Verdict, PatchesThatSlideInPartDoNotSlip) {
  Watched run = steady_run();
  run.slip(400, 0, 2.0 * kSlipping_m);
  run.ticks[400].contact.patch[0].sliding_share = 0.7;
  EXPECT_EQ(run.outcome(), Outcome::kHeld);
}

// A monitor that begins in the middle of a run answers for what it sees.
TEST(Verdict, CountsSlipFromWhereItsWatchBegins) {
  Watched run = steady_run();
  run.slip(0, 0, 1.0);
  run.ticks.erase(run.ticks.begin(), run.ticks.begin() + 400);
  EXPECT_EQ(run.outcome(), Outcome::kHeld);
}

// Forces chatter by 10 % from the tick 200 on: the mean of |second difference| / 2 is twice the amplitude of 5 %.
TEST(Verdict, ChatterCountsUpToTheFirstTrouble) {
  const auto late_chatter = [] { return steady_run([](int i) { return i < 200 ? 2.0 : i % 2 == 0 ? 2.1 : 1.9; }); };
  EXPECT_EQ(late_chatter().outcome(), Outcome::kUnstable);
  Watched run = late_chatter();
  run.unsolved_muscles(0.15);
  EXPECT_EQ(run.outcome(), Outcome::kSolverFailed);
  EXPECT_EQ(run.verdict().reason.find("chatter"), std::string::npos) << "it came of it";
  // 1.5 % is more than a steady grip has, but not clearly the cause of a slip that follows.
  run = steady_run([](int i) { return 2.0 + (i % 2 == 0 ? 0.015 : -0.015); });
  EXPECT_EQ(run.outcome(), Outcome::kUnstable);
  run.slip(450, 0, 1e-3);
  EXPECT_EQ(run.outcome(), Outcome::kSlipping);
}

// A position that is not a number passes no comparison: it must not pass for one that is near.
TEST(Verdict, WhatIsNotANumberIsNotHeld) {
  Watched run = steady_run();
  run.ticks[10].position_m[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(run.outcome(), Outcome::kSolverFailed);
}

// A stiffness without an answer is told as what it is: neither as torques without forces, nor as a stiffness that
// cannot be had. Where less of it was had, a run goes on with that, and only counts.
TEST(Verdict, NamesAStiffnessWithoutAnAnswer) {
  const auto reason = [](double share, bool is_infeasible) {
    Watched run = steady_run();
    ControlReport report = solved();
    report.stiffness.is_chosen = report.stiffness.is_unanswered = true;
    report.stiffness.share = share;
    report.stiffness.is_infeasible = is_infeasible;
    run.controls.emplace_back(0.4, report);
    const Verdict verdict = run.verdict();
    return std::pair(verdict.outcome, verdict.reason);
  };
  EXPECT_EQ(reason(0.0, false),
            std::pair(Outcome::kSolverFailed,
                      std::string("the problem of muscle forces for a stiffness found no answer at 0.400 s")));
  EXPECT_EQ(reason(0.0, true).first, Outcome::kOverLimits);
  EXPECT_EQ(reason(0.97, false).first, Outcome::kHeld);
}

TEST(Verdict, LostRecordsLeaveItOpen) {
  GraspMonitor monitor(minimal());
  for (const TickRecord& tick : steady_run().ticks) monitor.add(tick);
  monitor.miss("records were lost");
  EXPECT_EQ(in_words(monitor.verdict()), "unknown: records were lost");
}

}  // namespace
}  // namespace thenar::grasp_monitor_test
