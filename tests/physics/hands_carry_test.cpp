// Hands of other kinds, and a grasp that is found: human5, LEAP, Allegro and the published hand hold an object, carry it
// and turn it as box_grasp does, in one loop and with frames that come late. In real time: tests/app/run_test.cpp.

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "engine/scenes/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::hands_carry_test {
namespace {

class HandsCarry : public testing::TestWithParam<const char*> {};

void expect_carried(const Model& model, const RunSettings& settings) {
  State state(model);
  const Recording run = run_scene(model, state, settings);
  EXPECT_EQ(run.verdict.outcome, Outcome::kHeld) << in_words(run.verdict);
  ASSERT_FALSE(run.ticks.empty());
  // box_grasp's own limits: a tenth of a millimetre at the end, over the last 0.3 s, and 0.09 mm of slip, the micro-slip
  // of its patches.
  Eigen::Vector3d off_m = Eigen::Vector3d::Zero();
  int ticks = 0;
  const double end_s = run.ticks.back().time_s;
  for (const TickRecord& tick : run.ticks) {
    if (!tick.is_from(end_s - kFinalWindow_s)) continue;
    off_m += tick.position_m - tick.target_m;
    ++ticks;
  }
  EXPECT_LT((off_m / ticks).norm(), 0.1e-3);
  for (const double slip_m : run.ticks.back().slip_m) EXPECT_LT(slip_m, 0.09e-3);
  EXPECT_GT(run.ticks.back().target_m.norm(), 5e-3) << "it went somewhere";
}

TEST_P(HandsCarry, InOneLoop) { expect_carried(build_model(scene_of(GetParam())), {}); }

TEST_P(HandsCarry, InLockstepWithLateFrames) {
  const Model model = build_model(scene_of(GetParam(), {"time.control_period=5 ms", "time.control_delay=2 ms"}));
  expect_carried(model, {.lockstep = LockstepSettings{}});
}

INSTANTIATE_TEST_SUITE_P(Hands, HandsCarry, testing::Values("box_grasp", "human5_carry", "leap_carry", "allegro_carry"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace thenar::hands_carry_test
