// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "engine/environment/environment.h"
#include "engine/finder/hand_body.h"

namespace thenar {

/// The deepest reach of a hand into a body of the environment.
struct HandReach {
  double depth_m = 0.0;  ///< 0: it stays out of all of them.
  int body = -1;         ///< The body; -1: none.
  int finger = -1;       ///< The finger that reaches into it; -1: the palm.
};

/// Finds how deep the hand, as the spheres of hand_body() with its pulps, lies in the bodies of the environment at the
/// start, with the object at X_WO. Stops where it exceeds `enough_m`.
[[nodiscard]] HandReach hand_reach(const Environment& environment, const Hand& hand, const std::vector<BodyPoint>& body,
                                   const HandPose& pose, const Eigen::Isometry3d& X_WO,
                                   double enough_m = std::numeric_limits<double>::infinity());

}  // namespace thenar
