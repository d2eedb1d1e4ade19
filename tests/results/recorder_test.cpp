#include "engine/results/recorder.h"

#include <gtest/gtest.h>

#include "engine/results/grasp_monitor.h"
#include "engine/scenes/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::recorder_test {
namespace {

// A target that the caller moves is the target: in the record, and to the one who judges.
TEST(Recorder, ComparesWithTheTargetThatTheCallerWants) {
  const Model model = build_model(scene_of("minimal"));
  State state(model);
  state.tick = 400;
  state.X_WT = model.target(0.4) * Eigen::Translation3d(0.02, 0.0, 0.0);
  const TickRecord dragged = tick_record(model, state, TickReport(model.scene.hand), ControlReport(model.scene.hand));
  EXPECT_LT((dragged.target_m - Eigen::Vector3d(0.02, 0.0, 0.0)).norm(), 1e-6);  // the file's rotation is rounded
  const auto judged = [&](const TickRecord& tick) {
    GraspMonitor monitor(model);
    TickRecord loaded = tick;
    for (NormalTangential& force : loaded.force) force.normal_N = 1.0;
    monitor.add(loaded);
    return monitor.verdict().outcome;
  };
  EXPECT_EQ(judged(dragged), Outcome::kOffTarget);  // 20 mm behind it

  state.X_WO = *state.X_WT;
  EXPECT_EQ(judged(tick_record(model, state, TickReport(model.scene.hand), ControlReport(model.scene.hand))),
            Outcome::kHeld);
  state.X_WT.reset();
  EXPECT_TRUE(
      tick_record(model, state, TickReport(model.scene.hand), ControlReport(model.scene.hand)).target_m.isZero(1e-12));
}

}  // namespace
}  // namespace thenar::recorder_test
