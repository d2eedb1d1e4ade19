// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A binary tree over points: a node of L leaves splits its points along the longest axis of their box in the
/// proportion floor(L/2) : ceil(L/2), so that 2400 points in 320 leaves give 7 or 8 points a leaf. It has no links: the
/// points are ordered so that every node is a range, which follows from the numbers alone.

/// Orders the points (3 x n) by leaves, within a leaf by number; ties in a split are ordered by number, too.
/// Throws std::invalid_argument if leaves < 1 or > n.
[[nodiscard]] std::vector<Eigen::Index> order_by_leaves(const Eigen::Matrix3Xd& points_m, Eigen::Index leaves);

/// A node: the points [begin .. end) of that order.
struct TreeNode {
  Eigen::Index begin, end;
};

/// Returns the topmost nodes that have at most `most` leaves each, in order; with 1 the leaves.
[[nodiscard]] std::vector<TreeNode> tree_nodes(Eigen::Index points, Eigen::Index leaves, Eigen::Index most);

}  // namespace thenar
