#include "engine/control/pose_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"

namespace thenar::pose_loop_test {
namespace {

/// A held box that is nudged, its pose known so late, with a gain that makes rate times delay this much.
Scene nudged(int delay_ms, double delays) {
  const std::string delay = std::to_string(delay_ms) + " ms";
  Scene scene = scene_of("box_load", {kCoarseBox, "control.feedback_delay=" + delay, "task.lost=20 mm",
                                      "task.push={force: [0.1 N, 0.1 N, 0.1 N], from: 0.8 s, over: 0.1 s}"});
  Model model = build_model(scene);
  double low = 1.0, high = 1e5;  // The rate grows with the gain, though not in proportion: the rotation's stays.
  for (int i = 0; i < 40; ++i) {
    double& p = model.scene.control->position.p;
    p = scene.control->position.p = 0.5 * (low + high);
    (pose_rate(model) * loop_delay_s(scene) < delays ? low : high) = p;
  }
  return scene;
}

Verdict verdict_of(const Scene& scene) {
  const Model model = build_model(scene);
  State state(model);
  return run_scene(model, state).verdict;
}

// x' = -k x(t - T) is stable up to k T = pi/2. The fingers' viscosity counts with the object's: the object's alone
// would have it swing at a third of the gain. A tenth below it rings and is held, a tenth above it is unstable, and
// said to be.
TEST(PoseLoop, SwingsWiderFromHalfPiOn) {
  for (const int ms : {65, 100}) {
    const Verdict below = verdict_of(nudged(ms, 0.9 * kMostDelay));
    EXPECT_EQ(in_words(below), "held") << ms;
    const Verdict above = verdict_of(nudged(ms, 1.1 * kMostDelay));
    EXPECT_EQ(above.outcome, Outcome::kUnstable) << in_words(above);
    EXPECT_NE(above.reason.find("swung about its target, wider each time"), std::string::npos) << above.reason;
  }
}

// What was lost because it swung is told as that, and when it was lost.
TEST(PoseLoop, WhatItThrowsAwayIsUnstable) {
  const Verdict verdict = verdict_of(nudged(65, 2.0));
  EXPECT_EQ(verdict.outcome, Outcome::kUnstable) << in_words(verdict);
  EXPECT_TRUE(verdict.lost_s.has_value());
}

/// Whether swings of these sizes, one after the other, are told; about the axes or along one.
bool tells(const std::vector<double>& sizes, bool turns) {
  Swings swings;
  double way = 1.0;
  for (const double size : sizes) {
    for (int i = 0; i < 100; ++i) {
      const double off = size * std::sin(std::numbers::pi * i / 100.0);
      if (swings.add({0.0, turns ? 0.0 : way * off, 0.0}, turns ? std::abs(off) : 0.0)) return true;
    }
    way = -way;
  }
  return false;
}

std::vector<double> growing(double first, double factor, int count) {
  std::vector<double> sizes;
  for (int i = 0; i < count; ++i) sizes.push_back(first * std::pow(factor, i));
  return sizes;
}

// Growth is told, along an axis or about one; steady, dying and small swings are not, nor a beat, nor a ramp.
TEST(Swings, TellThoseThatGrow) {
  EXPECT_TRUE(tells(growing(0.2e-3, 1.15, 20), false));
  EXPECT_TRUE(tells(growing(5e-3, 1.15, 20), true));
  EXPECT_TRUE(tells(growing(0.1e-3, 3.0, 7), false));
  EXPECT_FALSE(tells(growing(0.2e-3, 1.0, 100), false));
  EXPECT_FALSE(tells(growing(5e-3, 0.95, 100), false));
  EXPECT_FALSE(tells(growing(1e-9, 1.15, 60), false));
  std::vector<double> beats;
  for (int i = 0; i < 100; ++i) beats.push_back(1e-3 * (1.0 + 0.3 * std::sin(i / 5.0)));
  EXPECT_FALSE(tells(beats, false));
  Swings ramp;
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(ramp.add({1e-5 * i, 0.0, 0.0}, 0.0).has_value());
}

}  // namespace
}  // namespace thenar::pose_loop_test
