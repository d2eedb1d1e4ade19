// SPDX-License-Identifier: Apache-2.0
#include "engine/results/recorder.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/results/grasp_monitor.h"
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

// The scene's duration is what a recorder makes room for, and no bound: a caller may run on.
TEST(Recorder, KeepsWhatComesAfterTheScenesEnd) {
  const Model model = build_model(scene_of("box_grasp", {"time.duration=5 ms"}));
  Recorder recorder(model);
  Snapshot state = State(model);
  const TickReport contact(model.scene.hand);
  const ControlReport control(model.scene.hand);
  const Eigen::VectorXd muscle_forces_N = Eigen::VectorXd::Zero(std::ssize(model.scene.hand.muscles));
  for (int i = 1; i <= 23; ++i) {
    state.pull_N.setConstant(i);
    EXPECT_TRUE(recorder.see_tick({state, contact, control, muscle_forces_N}));
  }
  const Recording recording = recorder.finish(state, control, 0.0);
  ASSERT_EQ(recording.muscle_forces_N.cols(), 23);
  for (int i = 1; i <= 23; ++i) EXPECT_TRUE((recording.muscle_forces_N.col(i - 1).array() == i).all()) << i;
}

// What a control period found of a stiffness is kept once, by all ticks of its frame.
TEST(Recorder, KeepsAStiffnessOncePerFrame) {
  const Model model = build_model(scene_of("box_stiff", {kCoarseBox, "time.control_period=5 ms"}));
  Recorder recorder(model);
  GraspRun run(model);
  std::vector<Watcher*> watchers{&recorder};
  run_ticks(run, 50, watchers);
  const Recording recording = recorder.finish(run.state, run.report, 0.0);
  ASSERT_EQ(recording.ticks.size(), 50U);
  std::set<const StiffnessRecord*> records;
  for (const TickRecord& tick : recording.ticks) {
    ASSERT_TRUE(tick.stiffness.now);
    records.insert(tick.stiffness.now.get());
  }
  EXPECT_EQ(records.size(), 10U);
}

// A patch's way is the sum of its slips as vectors from 0.3 s on, in the object's axes: here the object turns by 90
// degrees between two of them, which then go along the same line of it, there and back but for 1 um.
TEST(Recorder, AddsUpTheWayOfAPatch) {
  const Model model = build_model(scene_of("minimal"));
  RunSums sums;
  const auto added = [&](double time_s, double turned_rad, const Eigen::Vector3d& slip_W, double spin_rad) {
    TickRecord tick(model.scene.hand);
    tick.time_s = time_s;
    tick.X_WO.linear() = Eigen::AngleAxisd(turned_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    tick.contact.patch[1].slip_W = slip_W;
    tick.contact.patch[1].slip_m = slip_W.norm();
    tick.contact.patch[1].spin_rad = spin_rad;
    sums.add(tick);
    return tick;
  };
  EXPECT_TRUE(added(0.2, 0.0, {1e-3, 0.0, 0.0}, 0.5).walk_m[1].isZero(0.0)) << "the grip builds up";
  added(0.4, 0.0, {1e-4, 0.0, 0.0}, 0.3);
  const TickRecord last = added(0.5, 0.5 * std::numbers::pi, {0.0, -0.99e-4, 0.0}, -0.1);
  EXPECT_LE((last.walk_m[1] - Eigen::Vector3d(1e-6, 0.0, 0.0)).norm(), 1e-18);
  EXPECT_NEAR(last.turn_rad[1], 0.2, 1e-15);
  EXPECT_NEAR(last.slip_m[1], 1.199e-3, 1e-15) << "sizes add up";
  EXPECT_NEAR(last.spin_rad[1], 0.9, 1e-15);
  EXPECT_TRUE(last.walk_m[0].isZero(0.0));
}

// All ticks of a frame report its reflex: it began with the first of them, and is remembered.
TEST(Recorder, RemembersTheLastReflex) {
  const Model model = build_model(scene_of("minimal"));
  RunSums sums;
  const auto added = [&](double time_s, bool handed_over, ReflexEvent event, int finger) {
    TickRecord tick(model.scene.hand);
    tick.time_s = time_s;
    tick.contact.handed_over = handed_over;
    tick.reflex.event = event;
    tick.reflex.finger = finger;
    sums.add(tick);
    return tick.last_reflex;
  };
  EXPECT_EQ(added(0.1, true, ReflexEvent::kNone, -1).event, ReflexEvent::kNone);
  added(0.2, true, ReflexEvent::kSlip, 1);
  added(0.3, false, ReflexEvent::kSlip, 1);
  LastReflex last = added(0.4, true, ReflexEvent::kNone, -1);
  EXPECT_EQ(last.event, ReflexEvent::kSlip);
  EXPECT_EQ(last.finger, 1);
  EXPECT_EQ(last.time_s, 0.2);
  last = added(0.5, true, ReflexEvent::kLoad, 0);
  EXPECT_EQ(last.event, ReflexEvent::kLoad);
  EXPECT_EQ(last.time_s, 0.5);
}

}  // namespace
}  // namespace thenar::recorder_test
