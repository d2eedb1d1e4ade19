// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/hand_room.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/finder/known_surfaces.h"

namespace thenar::hand_room_test {
namespace {

using namespace known_surfaces;
using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Posed {
  const Hand& hand = human_hand();
  std::vector<BodyPoint> body = hand_body(hand);
  HandPose pose;

  Posed() { forward_kinematics(hand, hand.at_zero(), pose); }

  /// The least height of a sphere of the hand over the plane z = 0 of the world.
  [[nodiscard]] double lowest_m() const {
    double lowest_m = 1.0;
    for (const BodyPoint& point : body) lowest_m = std::min(lowest_m, point.in(pose).z() - point.clearance_m);
    for (int k = 0; k < hand.fingers(); ++k) {
      const Fingertip& tip = hand.fingertips[static_cast<std::size_t>(k)];
      lowest_m = std::min(lowest_m, (pose.distal(hand, k) * tip.centre_m).z() - tip.radius_m);
    }
    return lowest_m;
  }
};

Environment plane_at(double height_m) {
  EnvironmentBody plane;
  plane.name = "table";
  plane.shape = HalfSpace{};
  plane.X_WE.translation().z() = height_m;
  return {.bodies = {plane}, .compliance_m_per_N = 1e-7};
}

// The depth in a plane is that of the lowest sphere, and a hand above it reaches into nothing.
TEST(HandRoom, IsTheDepthOfTheLowestSphere) {
  const Posed at;
  constexpr double kDepth_m = 5e-3;
  const HandReach in =
      hand_reach(plane_at(at.lowest_m() + kDepth_m), at.hand, at.body, at.pose, Isometry3d::Identity());
  EXPECT_NEAR(in.depth_m, kDepth_m, 1e-12);
  EXPECT_EQ(in.body, 0);
  const HandReach out = hand_reach(plane_at(at.lowest_m() - 1e-9), at.hand, at.body, at.pose, Isometry3d::Identity());
  EXPECT_EQ(out.depth_m, 0.0);
  EXPECT_EQ(out.body, -1);
}

// Bodies in the object's frame go with the object.
TEST(HandRoom, GoesWithTheObject) {
  const Posed at;
  Environment environment = plane_at(0.0);
  environment.in_object_frame = true;
  Isometry3d X_WO = Isometry3d::Identity();
  X_WO.translation().z() = at.lowest_m() + 3e-3;
  EXPECT_NEAR(hand_reach(environment, at.hand, at.body, at.pose, X_WO).depth_m, 3e-3, 1e-12);
}

// A box and a sphere that hold one fingertip's centre in their middle are reached into by their half width, or radius,
// and the pulp's.
TEST(HandRoom, KnowsSolidsFromWithin) {
  const Posed at;
  const Fingertip& tip = at.hand.fingertips[1];
  const Vector3d centre_m = at.pose.distal(at.hand, 1) * tip.centre_m;
  for (const Solid& solid : {Solid(BoxShape{Vector3d(2e-3, 4e-3, 6e-3)}), Solid(CylinderShape{1e-3, 8e-3})}) {
    Environment environment = plane_at(0.0);
    environment.bodies[0].shape = solid;
    // Off the axis, on which the nearest point of a cylinder is not unique.
    environment.bodies[0].X_WE.translation() = centre_m - Vector3d(1e-9, 0.0, 0.0);
    const HandReach in = hand_reach(environment, at.hand, at.body, at.pose, Isometry3d::Identity());
    EXPECT_NEAR(in.depth_m, 1e-3 + tip.radius_m, 1e-8);
    EXPECT_EQ(in.finger, 1);
  }
}

}  // namespace
}  // namespace thenar::hand_room_test
