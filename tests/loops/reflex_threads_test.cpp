// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "engine/loops/threads.h"
#include "engine/models/build_model.h"
#include "engine/results/verdict.h"
#include "tests/support/scenes.h"

namespace thenar::reflex_threads_test {
namespace {

// The reflex between two threads: a box that becomes wet slides for as long as touch takes, and the frames on their
// way, and is caught. At a quarter of the speed, so that a busy machine is in time: in a hold no grip answers.
TEST(ReflexBetweenThreads, CatchesAWetBox) {
  const Model model = build_model(
      scene_of("box_wet", {kCoarseBox, "time.control_period=5 ms", "time.control_delay=5 ms", "task.lost=6 mm"}));
  double slip_m = 0.0;
  bool was_held = true;
  for (int attempt = 0; attempt < 3 && was_held; ++attempt) {
    State state(model);
    int events = 0;
    slip_m = 0.0;
    was_held = false;
    ThreadSettings settings;
    settings.duration_s = 1.2;
    settings.speed = 0.25;
    settings.on_tick = [&](const ContactSample& sample) {
      const PatchReport& patch = sample.step.tick.patch[0];
      if (patch.sliding_share >= kSlidesWhole && sample.after.tick > 300) slip_m += patch.slip_m;
      was_held = was_held || sample.after.held;
      return true;
    };
    settings.on_control = [&](const ControlSample& sample) {
      if (sample.step.control.reflex.event != ReflexEvent::kNone) ++events;
    };
    run_threads(model, state, settings);
    if (!was_held) {
      EXPECT_GT(events, 0);
      EXPECT_GT(state.load[0].normal_N, 3.5);  // It was 2.7 N when it was dry.
    }
  }
  if (was_held) GTEST_SKIP() << "frames came too late in three runs";
  // 0.018 m/s for 65 ms of touch, 5 ms of a frame's way, up to 5 until the next and 7 until the grip has risen; frames
  // that are later, but not so late that they are held, make it up to 20 ms more.
  EXPECT_NEAR(slip_m, 1.45e-3, 0.35e-3);
}

}  // namespace
}  // namespace thenar::reflex_threads_test
