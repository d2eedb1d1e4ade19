#include <gtest/gtest.h>

#include "engine/grasp_monitor.h"
#include "engine/recorder.h"
#include "tests/scenes.h"

namespace thenar {
namespace {

// A target that the caller moves is the target: in the record, and to the one who watches for a loss.
TEST(Recorder, ComparesWithTheTargetThatTheCallerWants) {
  const Model model(scene_of("minimal"));
  State state(model);
  state.tick = 400;
  state.X_WT = model.target(0.4) * Eigen::Translation3d(0.02, 0.0, 0.0);
  const TickRecord dragged = tick_record(model, state, TickReport{}, ControlReport{});
  EXPECT_LT((dragged.target_m - Eigen::Vector3d(0.02, 0.0, 0.0)).norm(), 1e-6);  // the file's rotation is rounded
  GraspMonitor monitor(model.scene.hand);
  TickRecord tick = dragged;
  EXPECT_TRUE(monitor.update(model.scene.step_s, tick));  // 20 mm behind it

  state.X_WO = *state.X_WT;
  tick = tick_record(model, state, TickReport{}, ControlReport{});
  EXPECT_FALSE(GraspMonitor(model.scene.hand).update(model.scene.step_s, tick));
  state.X_WT.reset();
  EXPECT_TRUE(tick_record(model, state, TickReport{}, ControlReport{}).target_m.isZero(1e-12));
}

}  // namespace
}  // namespace thenar
