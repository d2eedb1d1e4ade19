// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "engine/hand/hand.h"
#include "engine/imports/wrapping.h"

namespace thenar {

/// A point fixed in a segment of a hand.
struct SegmentPoint {
  int segment = 0;
  Eigen::Vector3d p_S;
};

/// A surface between two points of a tendon.
struct RouteWrap {
  int segment = 0;
  Eigen::Isometry3d X_SG;  ///< The surface in its segment.
  WrapSurface surface;
  std::optional<SegmentPoint> side;
};

/// A part of a tendon, from one point to the next.
struct RouteSpan {
  SegmentPoint from, to;
  std::optional<RouteWrap> wrap;
  double share = 1.0;  ///< Share of the muscle's force.
};

/// Computes the moment arms of a span for all joints of the hand: the torques by 1 N in the tendon [m].
[[nodiscard]] JointVector span_arms(const Hand& hand, const HandPose& pose, const RouteSpan& span);

/// Returns the joints that move one of two segments and not the other.
[[nodiscard]] std::vector<int> joints_between(const Hand& hand, int one_segment, int other_segment);

}  // namespace thenar
