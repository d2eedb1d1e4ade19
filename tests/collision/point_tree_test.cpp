// SPDX-License-Identifier: Apache-2.0
#include "collision/point_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "collision/shapes.h"

namespace thenar::point_tree_test {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

/// Points of a cubic lattice: whole layers tie in every split.
Matrix3Xd lattice(Index side) {
  Matrix3Xd points_m(3, side * side * side);
  for (Index i = 0; i < points_m.cols(); ++i) {
    points_m.col(i) = 1e-3 * Eigen::Matrix<Index, 3, 1>(i % side, i / side % side, i / side / side).cast<double>();
  }
  return points_m;
}

struct Case {
  const char* name;
  Matrix3Xd points_m;
  Index leaves;
};

std::vector<Case> cases() {
  return {{"fingertip", sample_sphere(8e-3, 2400).points_m, 320},
          {"box", sample_box({50e-3, 50e-3, 100e-3}, 3000).points_m, 400},
          {"odd numbers", sample_sphere(8e-3, 997).points_m, 101},
          {"one leaf", sample_sphere(8e-3, 50).points_m, 1},
          {"a point a leaf", sample_sphere(8e-3, 50).points_m, 50},
          {"lattice", lattice(8), 64},
          {"same place", Vector3d(1e-3, 2e-3, 3e-3).replicate(1, 20), 6}};
}

TEST(PointTree, EveryPointLiesInOneLeafInOrder) {
  for (const auto& [name, points_m, leaves] : cases()) {
    SCOPED_TRACE(name);
    const std::vector<Index> order = order_by_leaves(points_m, leaves);
    std::vector<Index> sorted = order, every(points_m.cols());
    std::sort(sorted.begin(), sorted.end());
    std::iota(every.begin(), every.end(), Index{0});
    EXPECT_EQ(sorted, every);

    const std::vector<TreeNode> nodes = tree_nodes(points_m.cols(), leaves, 1);
    ASSERT_EQ(std::ssize(nodes), leaves);
    Index next = 0;
    for (const TreeNode& leaf : nodes) {
      EXPECT_EQ(leaf.begin, next);
      EXPECT_GT(leaf.end, leaf.begin);
      EXPECT_TRUE(std::is_sorted(order.begin() + leaf.begin, order.begin() + leaf.end));
      next = leaf.end;
    }
    EXPECT_EQ(next, points_m.cols());
  }
}

TEST(PointTree, NodesSplitAlongTheirLongestAxis) {
  for (const auto& [name, points_m, leaves] : cases()) {
    const std::vector<Index> order = order_by_leaves(points_m, leaves);
    const auto points_of = [&, &points = points_m](const TreeNode& node) {
      const std::vector<Index> of(order.begin() + node.begin, order.begin() + node.end);
      return Matrix3Xd(points(Eigen::all, of));
    };
    // From a level to the next finer one: each node is there still, or stands as its two children.
    std::vector<TreeNode> above = tree_nodes(points_m.cols(), leaves, leaves);
    ASSERT_EQ(above.size(), 1U);
    for (Index most = leaves - 1; most > 0; --most) {
      SCOPED_TRACE(testing::Message() << name << ", " << most);
      const std::vector<TreeNode> below = tree_nodes(points_m.cols(), leaves, most);
      auto left = below.begin();
      for (const TreeNode& node : above) {
        ASSERT_EQ(left->begin, node.begin);
        if (left->end < node.end) {
          const auto right = left + 1;
          ASSERT_EQ(right->begin, left->end);
          ASSERT_EQ(right->end, node.end);
          const Matrix3Xd all = points_of(node);
          Index axis = 0;
          (all.rowwise().maxCoeff() - all.rowwise().minCoeff()).maxCoeff(&axis);
          EXPECT_LE(points_of(*left).row(axis).maxCoeff(), points_of(*right).row(axis).minCoeff());
          ++left;
        }
        ++left;
      }
      ASSERT_EQ(left, below.end());
      above = below;
    }
  }
}

TEST(PointTree, LeavesOfThePapersSizesHoldSevenOrEightPoints) {
  for (const auto& [points, leaves] : {std::pair<Index, Index>{2400, 320}, {36000, 4800}}) {
    for (const TreeNode& leaf : tree_nodes(points, leaves, 1)) {
      EXPECT_TRUE(leaf.end - leaf.begin == 7 || leaf.end - leaf.begin == 8) << leaf.end - leaf.begin;
    }
  }
}

TEST(PointTree, TiesGoByNumber) {
  // All points in one place: every split is decided by the number alone.
  const std::vector<Index> order = order_by_leaves(Matrix3Xd::Zero(3, 40), 5);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

TEST(PointTree, RefusesAnImpossibleNumberOfLeaves) {
  const Matrix3Xd points_m = sample_sphere(8e-3, 10).points_m;
  EXPECT_THROW(static_cast<void>(order_by_leaves(points_m, 0)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(order_by_leaves(points_m, -1)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(order_by_leaves(points_m, 11)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(order_by_leaves(Matrix3Xd(3, 0), 1)), std::invalid_argument);
  EXPECT_NO_THROW(static_cast<void>(order_by_leaves(points_m, 10)));
}

}  // namespace
}  // namespace thenar::point_tree_test
