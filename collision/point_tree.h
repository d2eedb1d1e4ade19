#pragma once

#include <Eigen/Core>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A binary tree over points: a node of L leaves splits its points along the longest axis of their box in the
/// proportion floor(L/2) : ceil(L/2), so that 2400 points in 320 leaves give 7 or 8 points a leaf. It needs no links:
/// the points are put in an order in which every node has a range, and numbers alone tell which.

/// The points (3 x n) leaf after leaf, in a leaf by number; points that tie in a split go by number, too.
/// Throws std::invalid_argument if leaves < 1 or > n.
[[nodiscard]] std::vector<Eigen::Index> order_by_leaves(const Eigen::Matrix3Xd& points_m, Eigen::Index leaves);

/// The points [begin .. end) of that order.
struct TreeNode {
  Eigen::Index begin, end;
};

/// The uppermost nodes that have no more than `most` leaves each, in order; with 1 the leaves.
[[nodiscard]] std::vector<TreeNode> tree_nodes(Eigen::Index points, Eigen::Index leaves, Eigen::Index most);

}  // namespace thenar
