// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "engine/hand/hand.h"
#include "engine/imports/body_tree.h"
#include "engine/imports/finger_chains.h"

namespace thenar {

/// A joint's axis, hand frame.
struct TreeAxis {
  Eigen::Vector3d origin_m, direction;
};

/// The poses of bodies and axes at zero of all fingers' joints, hand frame.
struct TreePose {
  std::vector<Eigen::Isometry3d> X_HB;      ///< One a body.
  std::vector<std::vector<TreeAxis>> axes;  ///< Axis per body and joint.
};

[[nodiscard]] TreePose pose_tree(const BodyTree& tree, const FingerChains& chains);

/// The assignment of bodies to the hand's segments.
struct TreeSegments {
  std::vector<int> of_body;  ///< Segment of each body; 0: the palm.
  std::vector<int> body;     ///< First body of each segment.
};

/// Adds the palm and the fingers' segments to a hand that has its joints, each with its origin at the joint before it.
[[nodiscard]] TreeSegments make_segments(const BodyTree& tree, const FingerChains& chains, const TreePose& pose,
                                         Hand& hand);

/// Orients the segments as in configs/hand.yaml, after the pulps are known: x to the next joint or the pulp, z along
/// the axis of a joint, as far as that is perpendicular.
void finish_segments(Hand& hand);

}  // namespace thenar
