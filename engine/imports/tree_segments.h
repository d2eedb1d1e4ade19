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

/// Where everything is while all fingers' joints are at zero, hand frame.
struct TreePose {
  std::vector<Eigen::Isometry3d> X_HB;      ///< One a body.
  std::vector<std::vector<TreeAxis>> axes;  ///< One a body, one a joint.
};

[[nodiscard]] TreePose pose_tree(const BodyTree& tree, const FingerChains& chains);

/// Which body is part of which of the hand's segments.
struct TreeSegments {
  std::vector<int> of_body;  ///< One a body; 0: the palm.
  std::vector<int> body;     ///< One a segment: its first body.
};

/// Adds the palm and the fingers' segments to a hand that has its joints, each with its origin at the joint before it.
[[nodiscard]] TreeSegments make_segments(const BodyTree& tree, const FingerChains& chains, const TreePose& pose,
                                         Hand& hand);

/// Turns the segments as configs/hand.yaml has them, now that the pulps are known: x to the next joint or the pulp, z
/// along the axis of a joint, as far as that lies across.
void finish_segments(Hand& hand);

}  // namespace thenar
