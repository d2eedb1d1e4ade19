// SPDX-License-Identifier: Apache-2.0
// What is shown of bodies around the object.

#include "engine/loops/shown_environment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/loops/live_input.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace thenar::shown_environment_test {
namespace {

using Eigen::Vector3d;

// At rest the slope carries the weight, right below the centre of mass: gravity and the slope's force are in one line.
TEST(ShownEnvironment, CarriesTheBoxWhereItsWeightGoes) {
  Loop loop(scene_of("resting_box"));
  loop.run(1.0);
  Picture picture(loop.model);
  take_picture(loop.state, loop.memory, loop.work, picture);
  const ShownEnvironment shown = shown_environment(loop.model, picture);
  const Vector3d weight_N = loop.model.scene.object.mass_kg * loop.model.scene.gravity;
  // What is left of the start has gone by exp(-t / 10 ms), m / d of the object: the solver's tolerance of 1e-6 decides.
  EXPECT_LE((shown.force_N.col(0) + weight_N).norm(), 1e-4 * weight_N.norm());
  const Vector3d arm_m = shown.mean_m.col(0) - loop.state.X_WO.translation();
  EXPECT_LE(arm_m.cross(weight_N.normalized()).norm(), 1e-4 * arm_m.norm());
  // Each point has what friction leaves: in sum tan(10 degrees) of 0.3.
  Vector3d sum_N = Vector3d::Zero();
  for (Eigen::Index i = 0; i < shown.margin.size() && std::isfinite(shown.margin[i]); ++i) {
    EXPECT_GE(shown.margin[i], -1e-9);  // Inside of its cone, to rounding.
    EXPECT_LE(shown.margin[i], 1.0);
    EXPECT_LE(shown.touch_N.col(i).norm(), shown.touch_N.col(std::max<Eigen::Index>(i - 1, 0)).norm());
    sum_N += shown.touch_N.col(i);
  }
  EXPECT_LE((sum_N - shown.force_N.col(0)).norm(), 1e-12 * sum_N.norm());
}

TEST(ShownEnvironment, TakesItsPictureWithoutMemory) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  Loop loop(scene_of("resting_box"));
  Picture picture(loop.model);
  loop.run(0.05);
  const AllocationCounter counter;
  take_picture(loop.state, loop.memory, loop.work, picture);
  EXPECT_EQ(counter.count(), 0);
  EXPECT_FALSE(picture.touches.empty());
}

// Before the first tick nothing touches, but all places are there: a message is as long as its scene says.
TEST(ShownEnvironment, HasAllPlacesBeforeTheFirstTick) {
  Scene scene = scene_of("resting_box");
  EnvironmentBody& body = scene.environment->bodies[0];
  body.moves = {{Vector3d(0.0, 0.0, 2e-3), 1.0, 1.0}};
  const Model model = build_model(scene);
  Picture picture(model);
  const ShownEnvironment first = shown_environment(model, picture);
  EXPECT_EQ(first.touch_N.cols(), static_cast<Eigen::Index>(most_touches(scene)));
  EXPECT_TRUE(first.margin.array().isNaN().all());
  EXPECT_EQ(Vector3d(first.force_N.col(0)), Vector3d::Zero());
  EXPECT_TRUE(first.mean_m.col(0).array().isNaN().all());
  // Bodies are where the picture's time has them.
  picture.snapshot.tick = std::lround(1.5 / scene.step_s);
  const Vector3d moved_m = shown_environment(model, picture).X_WE[0].translation() - first.X_WE[0].translation();
  // A minimum-jerk move is half done after half of its time; positions of 0.3 m round to 1e-16 of that.
  EXPECT_LE((moved_m - Vector3d(0.0, 0.0, 1e-3)).norm(), 1e-15);
}

/// A peg of 20 mm that stands in a hole with 0.2 mm more, 40 mm deep, and the hand away.
Scene peg_in_hole() {
  Scene scene = scene_of("resting_box");
  scene.object.shape = CylinderShape{10e-3, 60e-3};
  scene.object.X_WO = Eigen::Isometry3d(Eigen::Translation3d(0.3, 0.0, -10e-3));
  scene.environment->bodies[0].shape = HoleShape{10.1e-3, 40e-3, 1e-3};
  scene.environment->bodies[0].X_WE = Eigen::Isometry3d(Eigen::Translation3d(0.3, 0.0, 0.0));
  return scene;
}

// Hands that pull a peg sideways, as hard as a page may, hold it against the walls and no farther.
TEST(LiveHands, DoNotPullAPegOutOfItsHole) {
  Loop loop(peg_in_hole());
  LiveHands hands(loop.model);
  LiveInput input;
  input.number = 1;
  input.pull = {{0.0, 0.0, 30e-3}, {0.9, 0.3, 0.02}};
  Picture picture(loop.model);
  const double radius_m = 10e-3, reach_m = 10.1e-3;
  for (std::int64_t tick = 0; tick < 1000; ++tick) {
    const std::int64_t now_ns = tick * 1'000'000;
    input.pull_heard_ns = now_ns;
    loop.tick(hands.next(input, loop.state, now_ns));
    take_picture(loop.state, loop.memory, loop.work, picture);
    // Object and walls give way by 100 nm/N, and lean on two places with the forces of a lever: no more than ten times
    // the 2 N of the pull at each. Tilted by no more than 0.2 mm in 40 mm, the peg's section is wider by 2e-5 of it.
    const double most_m = reach_m - radius_m + 20.0 * 100e-9 + 2e-5 * radius_m;
    const Vector3d axis = loop.state.X_WO.linear().col(2), middle_m = loop.state.X_WO.translation();
    for (const double z_m : {-1e-3, -39e-3}) {
      const Vector3d at_m = middle_m + (z_m - middle_m.z()) / axis.z() * axis;
      ASSERT_LE(std::hypot(at_m.x() - 0.3, at_m.y()), most_m) << "after " << tick << " ticks, at " << z_m;
    }
  }
  // At rest the hole holds against the pull and carries the weight.
  ASSERT_TRUE(hands.pull());
  const Vector3d pull_N = hands.pull()->force_N;
  EXPECT_NEAR(pull_N.norm(), kPullLimit_N, 1e-9);
  const Vector3d weight_N = loop.model.scene.object.mass_kg * loop.model.scene.gravity;
  const ShownEnvironment shown = shown_environment(loop.model, picture);
  EXPECT_LE((shown.force_N.col(0) + pull_N + weight_N).norm(), 1e-3 * kPullLimit_N);
}

}  // namespace
}  // namespace thenar::shown_environment_test
