// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <thread>

#include "engine/control/control_period.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"

namespace thenar::own_control_test {
namespace {

/// Contact at 1 kHz, control at 200 Hz, for so long.
Model split_box(double duration_s) {
  Scene scene = split_scene();
  scene.duration_s = duration_s;
  scene.task = {};  // The target rests: what is seen is the hold alone.
  return build_model(scene);
}

ThreadSettings threads(const Model& model, OwnControl own) {
  ThreadSettings settings;
  settings.duration_s = model.scene.duration_s;
  settings.realtime = false;
  settings.quiet = true;
  settings.own = std::move(own);
  return settings;
}

// A function handed to a run is the run's controller: the published one gives the published run, one tick as the other.
TEST(OwnControlOfRuns, ThePublishedOneHandedInGivesThePublishedRun) {
  const Model model = split_box(0.2);
  RunSettings settings;
  for (const bool lockstep : {false, true}) {
    if (lockstep) settings.lockstep = LockstepSettings{.jitter_s = 1e-3};
    State plain(model), handed(model);
    settings.own = {};
    const Recording one = run_scene(model, plain, settings);
    settings.own.torques = published_torques;
    const Recording other = run_scene(model, handed, settings);
    EXPECT_EQ(plain.q, handed.q);
    EXPECT_EQ(plain.X_WO.matrix(), handed.X_WO.matrix());
    EXPECT_EQ(one.ticks.size(), other.ticks.size());
  }
}

// A law that does not come back for 300 ms: frames grow old, their drive is held, and the object stays where it is,
// within 1 mm; then all goes on. That of two threads is the machine's time, so no other time is looked at.
TEST(OwnControlOfRuns, AStallIsAHold) {
  const Model model = split_box(1.0);
  int calls = 0;
  OwnControl own;
  own.torques = [&calls](ControlPeriod& period) {
    if (++calls == 80) std::this_thread::sleep_for(std::chrono::milliseconds(300));
    return published_torques(period);
  };
  State state(model);
  const RealtimeRun run = run_realtime(model, state, threads(model, own));
  std::int64_t held = 0;
  for (const TickRecord& tick : run.recording.ticks) held += tick.contact.held;
  EXPECT_GT(held, 0);
  EXPECT_FALSE(run.recording.verdict.lost_s);
  for (const TickRecord& tick : run.recording.ticks) {
    ASSERT_LE((tick.position_m - tick.target_m).norm(), 1e-3) << tick.time_s << " s";
  }
}

// What a law throws ends the run, and is thrown by it: in one loop, and on the control thread of two.
TEST(OwnControlOfRuns, WhatALawThrowsEndsTheRun) {
  const Model model = split_box(1.0);
  OwnControl own;
  own.torques = [](ControlPeriod& period) -> JointVector {
    if (period.time_s() > 0.1) throw std::domain_error("mine");
    return published_torques(period);
  };
  State state(model);
  EXPECT_THROW((void)run_scene(model, state, {.own = own}), std::domain_error);
  State again(model);
  EXPECT_THROW((void)run_realtime(model, again, threads(model, own)), std::domain_error);
}

// A run that goes on as another does so to the last bit, from between two control ticks, with frames on their way.
TEST(OwnControlOfRuns, ARunGoesOnAsAnother) {
  const Model model = split_box(1.0);
  GraspRun one(model, LockstepSettings{.jitter_s = 3e-3, .seed = 5}), other(model, LockstepSettings{.jitter_s = 3e-3});
  for (int i = 0; i < 123; ++i) one.tick();
  other.go_on_as(one);
  for (int i = 0; i < 60; ++i) {
    one.tick();
    other.tick();
  }
  EXPECT_EQ(one.state.q, other.state.q);
  EXPECT_EQ(one.state.X_WO.matrix(), other.state.X_WO.matrix());
  EXPECT_EQ(one.frame.sequence, other.frame.sequence);
}

}  // namespace
}  // namespace thenar::own_control_test
