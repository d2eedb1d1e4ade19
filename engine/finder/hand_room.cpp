// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/hand_room.h"

#include <algorithm>
#include <optional>

#include "collision/solids/solid.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

/// Returns the depth of a sphere in a solid, in the solid's frame; 0 outside.
double depth_in(const Solid& solid, const Vector3d& centre_m, double radius_m) {
  double depth_m = 0.0;
  for (int facet = 0; facet < facets(solid); ++facet) {
    const std::optional<Foot> at = foot(solid, facet, centre_m);
    if (at) depth_m = std::max(depth_m, radius_m - at->gap_m);
  }
  return depth_m;
}

}  // namespace

HandReach hand_reach(const Environment& environment, const Hand& hand, const std::vector<BodyPoint>& body,
                     const HandPose& pose, const Isometry3d& X_WO, double enough_m) {
  HandReach most;
  for (int k = 0; k < static_cast<int>(environment.bodies.size()); ++k) {
    const EnvironmentBody& solid = environment.bodies[static_cast<std::size_t>(k)];
    const Isometry3d X_EW = (environment.in_object_frame ? X_WO * solid.X_WE : solid.X_WE).inverse();
    const auto look = [&](const Vector3d& centre_W, double radius_m, int finger) {
      const double depth_m = depth_in(solid.shape, X_EW * centre_W, radius_m);
      if (depth_m > most.depth_m) most = {depth_m, k, finger};
    };
    for (int finger = 0; finger < hand.fingers(); ++finger) {
      const Fingertip& tip = hand.fingertips[static_cast<std::size_t>(finger)];
      look(pose.distal(hand, finger) * tip.centre_m, tip.radius_m, finger);
      if (most.depth_m > enough_m) return most;
    }
    for (const BodyPoint& point : body) {
      look(point.in(pose), point.clearance_m, point.segment < 0 ? -1 : point.finger);
      if (most.depth_m > enough_m) return most;
    }
  }
  return most;
}

}  // namespace thenar
