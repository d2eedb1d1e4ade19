// SPDX-License-Identifier: Apache-2.0
// What rests has to stay where it is: a box on a slope that friction holds, and one over a table's edge.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"

namespace thenar::resting_box_test {
namespace {

using Eigen::Vector3d;

class RestingBox : public testing::TestWithParam<const char*> {};

// Neither friction nor the ground makes energy, and nothing creeps: 1 nm/s would be 50 nm in 50 s.
TEST_P(RestingBox, GainsNoEnergyAndDoesNotCreep) {
  const Model model = build_model(scene_of(GetParam()));
  State state(model);
  const Recording run = run_scene(model, state);
  ASSERT_EQ(run.ticks.size(), 60'000U);
  const Ledger& ledger = run.ticks.back().ledger;
  EXPECT_LE(ledger.injected_J, 1e-9);
  EXPECT_LE(std::abs(ledger.unbalanced_J()), 1e-9);
  const TickRecord &early = run.ticks[9'999], &last = run.ticks.back();
  EXPECT_LE((last.position_m - early.position_m).norm(), 50e-9);
  // Corners are 52 mm from the centre.
  EXPECT_LE(52e-3 * std::abs(last.rotation_error_rad - early.rotation_error_rad), 50e-9);
  EXPECT_EQ(run.verdict.outcome, Outcome::kResting) << in_words(run.verdict);
}
INSTANTIATE_TEST_SUITE_P(Scenes, RestingBox, testing::Values("resting_box", "resting_edge"));

// The contact tick finds what the environment does by itself: frames that come late, and when they come, change nothing
// of it.
TEST(RestingOnASlope, IsAlikeInAllRunners) {
  const Model model = build_model(scene_of("resting_box", {"time.duration=1 s", "time.control_delay=20 ms"}));
  State one(model), late(model), threaded(model);
  const Recording in_one = run_scene(model, one),
                  in_lockstep = run_scene(model, late, {.lockstep = LockstepSettings{}});
  ThreadSettings settings;
  settings.duration_s = model.scene.duration_s;
  settings.realtime = false;
  settings.quiet = true;
  const Recording in_threads = run_realtime(model, threaded, settings).recording;
  for (const Recording* run : {&in_one, &in_lockstep, &in_threads}) {
    // On a busy machine threads give up ticks; the box rests long before.
    ASSERT_GE(run->ticks.size(), 200U);
    const TickRecord &last = run->ticks.back(), &expected = in_one.ticks.back();
    EXPECT_LE((last.position_m - expected.position_m).norm(), 1e-12);
    EXPECT_LE((last.contact.environment.wrench - expected.contact.environment.wrench).norm(), 1e-9);
    EXPECT_EQ(last.contact.environment.active, 4);
    EXPECT_EQ(run->verdict.outcome, Outcome::kResting) << in_words(run->verdict);
  }
}

}  // namespace
}  // namespace thenar::resting_box_test
