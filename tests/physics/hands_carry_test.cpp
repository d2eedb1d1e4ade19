// SPDX-License-Identifier: Apache-2.0
// Hands of other kinds, and a grasp that is found: human5, LEAP, Allegro and the published hand hold an object, carry
// it and turn it as box_grasp does, in one loop, with frames that come late, and in real time.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "engine/loops/threads.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "tests/support/carried.h"
#include "tests/support/scenes.h"

namespace thenar::hands_carry_test {
namespace {

/// A patch of the published box grasp slides by 0.08 mm at its rim; grasps that are found do not reach the 0.02 mm that
/// a patch may slide.
class HandsCarry : public testing::TestWithParam<const char*> {
 protected:
  static double most_slip_m() { return GetParam() == std::string("box_grasp") ? 0.09e-3 : 0.02e-3; }
};

TEST_P(HandsCarry, InOneLoop) { expect_carried(build_model(scene_of(GetParam())), {}, most_slip_m()); }

TEST_P(HandsCarry, InLockstepWithLateFrames) {
  const Model model = build_model(scene_of(GetParam(), {"time.control_period=5 ms", "time.control_delay=2 ms"}));
  expect_carried(model, {.lockstep = LockstepSettings{}}, most_slip_m());
}

// Two threads in real time, which a loaded machine does not keep: ticks slip, so that simulated time lags, and frames
// get old, so that the drive is held while the target goes on. Whatever happens, all fingers keep the object, which
// goes no farther than 10 mm beyond what it is asked to, the error that the monitor calls a loss; one that is let go
// falls by 100 mm and more in half a second (2 N on 10 N s/m). Where at least three quarters of the ticks are done, and
// none of the last half second's with a held drive, it also arrives.
TEST_P(HandsCarry, InRealTime) {
  const Model model =
      build_model(scene_of(GetParam(), {"time.control_period=5 ms", "time.duration=1.5 s", "task.translate.from=0.1 s",
                                        "contact.tolerance=1e-7", "contact.max_sweeps=60"}));
  const auto from_start_m = [&](const Eigen::Isometry3d& X_WO) {
    return (X_WO.translation() - model.scene.object.X_WO.translation()).norm();
  };
  const double asked_m = model.scene.task.translate.value().amount;
  double farthest_m = 0.0;
  std::int64_t last_hold = 0;
  ThreadSettings settings;
  settings.duration_s = model.scene.duration_s;
  settings.quiet = true;
  settings.on_tick = [&](const ContactSample& sample) {
    farthest_m = std::max(farthest_m, from_start_m(sample.after.X_WO));
    if (sample.after.held) last_hold = sample.after.tick;
    return true;
  };
  State state(model);
  const ThreadsReport report = run_threads(model, state, settings);
  SCOPED_TRACE(testing::Message() << report.contact.policy << ", slipped " << report.slipped);
  EXPECT_EQ(report.ticks + report.slipped, 1500);
  EXPECT_LT(farthest_m, asked_m + 10e-3);
  for (int k = 0; k < model.fingers(); ++k) EXPECT_GT(state.load[k].normal_N, 0.1) << k;
  if (report.slipped > 375 || last_hold > state.tick - 500)
    GTEST_SKIP() << "this machine gave ticks or frames too little time";
  EXPECT_GT(from_start_m(state.X_WO), asked_m - 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Hands, HandsCarry, testing::Values("box_grasp", "human5_carry", "leap_carry", "allegro_carry"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace thenar::hands_carry_test
