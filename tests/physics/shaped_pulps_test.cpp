// SPDX-License-Identifier: Apache-2.0
// Hands with pulps that are ellipsoids and capsules: they find a grasp of a box, hold it, carry it and turn it as
// spheres do; as rigid ones, too, and mirrored.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "engine/grasp/pulp_touch.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/carried.h"
#include "tests/support/scenes.h"

namespace thenar::shaped_pulps_test {
namespace {

using Eigen::Vector3d;

enum class Kind { kEllipsoids, kCapsules, kMixed };

/// As thick as the spheres were where they face, wider along the finger.
void reshape(Hand& hand, Kind kind) {
  for (std::size_t k = 0; k < hand.fingertips.size(); ++k) {
    Fingertip& tip = hand.fingertips[k];
    const double r = tip.radius_m;
    if (kind == Kind::kMixed && k == 1) continue;
    if (kind == Kind::kCapsules || (kind == Kind::kMixed && k == 2)) {
      Eigen::Matrix3d axes;
      axes << Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ();
      tip.radius_m = 0.85 * r;
      tip.shape = PulpShape{PulpShape::Form::kCapsule, axes, {0.4 * r, 0.85 * r, 0.85 * r}};
    } else {
      Eigen::Matrix3d axes;
      const Vector3d along = (Vector3d::UnitX() - tip.normal.x() * tip.normal).normalized();
      axes << along, tip.normal.cross(along), tip.normal;
      tip.shape = PulpShape{PulpShape::Form::kEllipsoid, axes, {1.35 * r, r, 0.85 * r}};
      tip.radius_m = tip.shape->inner_radius_m();
    }
  }
}

Scene carry_scene(Kind kind, const std::vector<std::string>& overrides = {}) {
  std::vector<std::string> all{"hand.model=" + config_file("hand").string()};
  all.insert(all.end(), overrides.begin(), overrides.end());
  Scene scene = scene_of("human5_carry", all);
  reshape(scene.hand, kind);
  return scene;
}

/// A patch of capsules is nearly a line, whose ends slip first when it is turned: the micro-slip of its middle may be
/// twice as much.
double most_slip_m(Kind kind) { return kind == Kind::kCapsules ? 0.18e-3 : 0.09e-3; }

class ShapedPulps : public testing::TestWithParam<Kind> {};

TEST_P(ShapedPulps, CarryTheBoxInOneLoop) {
  expect_carried(build_model(carry_scene(GetParam())), {}, most_slip_m(GetParam()));
}

TEST_P(ShapedPulps, CarryTheBoxWithLateFrames) {
  const Scene scene = carry_scene(GetParam(), {"time.control_period=5 ms", "time.control_delay=2 ms"});
  expect_carried(build_model(scene), {.lockstep = LockstepSettings{}}, most_slip_m(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Kinds, ShapedPulps, testing::Values(Kind::kEllipsoids, Kind::kCapsules, Kind::kMixed));

// The start is what the finder promised: every pulp is pressed in by about the depth of its load, nowhere more than the
// trust in it, and its least distance from the box is where its ball says.
TEST(ShapedPulps, BeginPressedIn) {
  for (const Kind kind : {Kind::kEllipsoids, Kind::kCapsules}) {
    const Model model = build_model(carry_scene(kind));
    HandPose pose;
    forward_kinematics(model.scene.hand, model.scene.posture, pose);
    for (int k = 0; k < model.fingers(); ++k) {
      const Fingertip& tip = model.scene.hand.fingertips[k];
      const Eigen::Isometry3d X_OF = model.scene.object.X_WO.inverse() * pose.distal(model.scene.hand, k);
      const PulpBall ball = touching_ball(tip, model.object, X_OF);
      const double depth_m = ball.radius_m - model.object.distance(X_OF * ball.centre_m, 1.0)->distance_m;
      EXPECT_GT(depth_m, 0.1e-3);
      EXPECT_LT(depth_m, kTrustPerRadius * tip.radius_m);
      // The deepest control point is as deep, less what lies between points: (spacing / 2)^2 over twice a radius.
      double deepest_m = 0.0;
      const Pulp& pulp = model.pulps[k];
      for (Eigen::Index c = 0; c < pulp.controls(); ++c) {
        const auto at = model.object.distance(X_OF * pulp.control_points_m.col(c), 0.02);
        if (at) deepest_m = std::max(deepest_m, -at->distance_m);
      }
      EXPECT_LE(deepest_m, depth_m + 2e-6);
      EXPECT_GE(deepest_m, depth_m - pulp.area_m2.maxCoeff() / (2.0 * tip.radius_m));
    }
  }
}

// Rigid pulps of any shape hold the box at one point each, and no tick takes memory.
TEST(ShapedPulps, HoldAsRigidOnes) {
  for (const Kind kind : {Kind::kEllipsoids, Kind::kCapsules}) {
    Scene scene = carry_scene(kind);
    const Model soft = build_model(scene);
    scene = soft.scene;
    scene.fingertips.reset();
    scene.contact.max_per_finger = 1;
    scene.control->pulp_normal_N_per_m = 50e3;
    scene.control->pulp_tangential_N_per_m = 33.3e3;
    Model model = build_model(scene, soft);
    Loop loop(std::move(model));
    loop.run(0.3);
    for (const FingerLoad& load : loop.state.load) EXPECT_GT(load.normal_N, 0.2);
    const Vector3d off_m = loop.state.X_WO.translation() - scene.object.X_WO.translation();
    EXPECT_LT(off_m.norm(), 2e-3);
    if (!AllocationCounter::is_available()) continue;
    const AllocationCounter counter;
    for (int tick = 0; tick < 20; ++tick) (void)loop.tick();
    EXPECT_EQ(counter.count(), 0);
  }
}

}  // namespace
}  // namespace thenar::shaped_pulps_test
