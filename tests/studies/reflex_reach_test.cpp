// SPDX-License-Identifier: Apache-2.0
#include "engine/studies/reflex_reach.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"

namespace thenar::reflex_reach_test {
namespace {

using Changes = std::vector<std::string>;

/// All that is known is so old.
Changes late(int ms) {
  const std::string delay = std::to_string(ms) + " ms";
  return {kCoarseBox, "control.feedback_delay=" + delay, "fingertips.touch.delay=" + delay};
}

bool is_lost(const std::string& name, Changes changes, const std::string& change) {
  changes.push_back(change);
  const Model model = build_model(scene_of(name, changes));
  State state(model);
  return run_scene(model, state).verdict.outcome == Outcome::kLost;
}

std::string push(double load_N) { return "task.push.force=[0 N, 0 N, " + std::to_string(-load_N) + " N]"; }
std::string wet(double friction) { return "task.friction=[{at: 0.8 s, to: " + std::to_string(friction) + "}]"; }

// A tenth less than the largest load is held, and a tenth more is lost, by runs of the whole model: patches of points,
// three fingers that yield each in its own way, an object that turns.
TEST(ReflexReach, TellsTheLargestLoad) {
  for (const int ms : {30, 65, 100}) {
    const auto reach = reflex_reach(build_model(scene_of("box_load", late(ms))));
    ASSERT_TRUE(reach.has_value());
    EXPECT_FALSE(is_lost("box_load", late(ms), push(0.9 * reach->load_N))) << ms << " ms, " << reach->load_N << " N";
    EXPECT_TRUE(is_lost("box_load", late(ms), push(1.1 * reach->load_N))) << ms << " ms, " << reach->load_N << " N";
  }
}

// And likewise the least friction, where it is the latency that counts: what pulps that are let go of spring back,
// 0.2 mm of the 2 mm that are forgiven, is left out, and at 30 ms makes a fifth of the friction.
TEST(ReflexReach, TellsTheLeastFriction) {
  for (const int ms : {65, 80, 100}) {
    const auto reach = reflex_reach(build_model(scene_of("box_wet", late(ms))));
    ASSERT_TRUE(reach.has_value() && reach->friction.has_value());
    const double friction = *reach->friction;
    EXPECT_FALSE(is_lost("box_wet", late(ms), wet(1.1 * friction))) << ms << " ms, " << friction;
    EXPECT_TRUE(is_lost("box_wet", late(ms), wet(0.9 * friction))) << ms << " ms, " << friction;
  }
}

}  // namespace
}  // namespace thenar::reflex_reach_test
