#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "collision/shapes.h"
#include "collision/sphere_tree.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Points of a cubic lattice: whole layers tie in every split.
PointCloud lattice(Index side) {
  PointCloud cloud{Eigen::Matrix3Xd(3, side * side * side), Eigen::Matrix3Xd::Zero(3, side * side * side)};
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    cloud.points_m.col(i) =
        1e-3 * Eigen::Matrix<Index, 3, 1>(i % side, i / side % side, i / side / side).cast<double>();
  }
  cloud.normals.row(2).setOnes();
  return cloud;
}

struct Case {
  const char* name;
  PointCloud cloud;
  Index leaves;
};

std::vector<Case> cases() {
  const PointCloud same_place{Vector3d(1e-3, 2e-3, 3e-3).replicate(1, 20), Vector3d::UnitX().replicate(1, 20)};
  return {{"fingertip", sample_sphere(8e-3, 2400), 320},
          {"box", sample_box({50e-3, 50e-3, 100e-3}, 3000), 400},
          {"odd numbers", sample_sphere(8e-3, 997), 101},
          {"one leaf", sample_sphere(8e-3, 50), 1},
          {"a point a leaf", sample_sphere(8e-3, 50), 50},
          {"lattice", lattice(8), 64},
          {"same place", same_place, 6}};
}

TEST(SphereTree, EverySampleLiesInOneLeafInOrder) {
  for (const auto& [name, cloud, leaves] : cases()) {
    SCOPED_TRACE(name);
    const SphereTree tree(cloud, leaves);
    std::vector<Index> sorted = tree.order(), every(cloud.points_m.cols());
    std::sort(sorted.begin(), sorted.end());
    std::iota(every.begin(), every.end(), Index{0});
    EXPECT_EQ(sorted, every);

    ASSERT_EQ(static_cast<Index>(tree.leaves().size()), leaves);
    Index next = 0;
    for (Index leaf = 0; leaf < leaves; ++leaf) {
      const SphereTree::Node& node = tree.nodes()[tree.leaves()[leaf]];
      EXPECT_TRUE(node.is_leaf());
      EXPECT_EQ(node.right, leaf);
      EXPECT_EQ(node.begin, next);
      EXPECT_GT(node.end, node.begin);
      next = node.end;
    }
    EXPECT_EQ(next, cloud.points_m.cols());
  }
}

TEST(SphereTree, ChildrenShareTheirParentsSamples) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const PointCloud& cloud = c.cloud;
    const SphereTree tree(cloud, c.leaves);
    EXPECT_EQ(tree.nodes().front().begin, 0);
    EXPECT_EQ(tree.nodes().front().end, cloud.points_m.cols());
    for (const SphereTree::Node& node : tree.nodes()) {
      if (node.is_leaf()) continue;
      const SphereTree::Node &left = tree.nodes()[node.left], &right = tree.nodes()[node.right];
      EXPECT_EQ(left.begin, node.begin);
      EXPECT_EQ(left.end, right.begin);
      EXPECT_EQ(right.end, node.end);

      // The split is along the longest axis: there, no sample of the left is above one of the right.
      const auto points_of = [&](const SphereTree::Node& n) {
        const std::vector<Index> order(tree.order().begin() + n.begin, tree.order().begin() + n.end);
        return Eigen::Matrix3Xd(cloud.points_m(Eigen::all, order));
      };
      const Eigen::Matrix3Xd all = points_of(node);
      Index axis = 0;
      (all.rowwise().maxCoeff() - all.rowwise().minCoeff()).maxCoeff(&axis);
      EXPECT_LE(points_of(left).row(axis).maxCoeff(), points_of(right).row(axis).minCoeff());
    }
  }
}

TEST(SphereTree, LeavesOfThePapersSizesHoldSevenOrEightSamples) {
  const auto expect_seven_or_eight = [](const PointCloud& cloud, Index leaves) {
    const SphereTree tree(cloud, leaves);
    for (const Index leaf : tree.leaves()) {
      const Index samples = tree.nodes()[leaf].end - tree.nodes()[leaf].begin;
      EXPECT_TRUE(samples == 7 || samples == 8) << samples;
    }
  };
  expect_seven_or_eight(sample_sphere(8e-3, 2400), 320);
  // Only the number counts here, so random points do for the object.
  expect_seven_or_eight({Eigen::Matrix3Xd::Random(3, 36000), Eigen::Matrix3Xd::Zero(3, 36000)}, 4800);
}

TEST(SphereTree, SpheresContainTheirSamplesTightly) {
  for (const auto& [name, cloud, leaves] : cases()) {
    SCOPED_TRACE(name);
    const SphereTree tree(cloud, leaves);
    for (const SphereTree::Node& node : tree.nodes()) {
      double widest_m = 0.0;
      for (Index k = node.begin; k < node.end; ++k) {
        const Vector3d p = cloud.points_m.col(tree.order()[k]);
        // The radius is the distance of the farthest sample, to rounding.
        EXPECT_LE((p - node.centre_m).norm(), node.radius_m * (1.0 + 1e-14));
        for (Index j = node.begin; j < k && node.end - node.begin < 100; ++j) {
          widest_m = std::max(widest_m, (p - cloud.points_m.col(tree.order()[j])).norm());
        }
      }
      // The smallest sphere has a radius of at most sqrt(3/8) widths [Jung 1901], Ritter's is up to a fifth larger.
      if (node.end - node.begin < 100) {
        EXPECT_LE(node.radius_m, 1.2 * std::sqrt(3.0 / 8.0) * widest_m + 1e-18);
      }
    }
  }
}

TEST(SphereTree, TheSampleNearestTheMeanRepresentsANode) {
  const PointCloud cloud = sample_sphere(8e-3, 997);
  const SphereTree tree(cloud, 101);
  for (const SphereTree::Node& node : tree.nodes()) {
    const std::vector<Index> order(tree.order().begin() + node.begin, tree.order().begin() + node.end);
    const Eigen::Matrix3Xd points = cloud.points_m(Eigen::all, order);
    const Vector3d mean = points.rowwise().mean();
    EXPECT_EQ(std::count(order.begin(), order.end(), node.representative), 1);
    // Rounding of the mean: two samples equally near may swap.
    EXPECT_LE((cloud.points_m.col(node.representative) - mean).norm(),
              (points.colwise() - mean).colwise().norm().minCoeff() + 1e-15);
  }
}

TEST(SphereTree, TiesGoByIndex) {
  // All samples in one place: every split is decided by the index alone.
  const PointCloud cloud{Eigen::Matrix3Xd::Zero(3, 40), Vector3d::UnitZ().replicate(1, 40)};
  const SphereTree tree(cloud, 5);
  EXPECT_TRUE(std::is_sorted(tree.order().begin(), tree.order().end()));
}

TEST(SphereTree, RefusesAnImpossibleNumberOfLeaves) {
  const PointCloud cloud = sample_sphere(8e-3, 10);
  EXPECT_THROW(SphereTree(cloud, 0), std::invalid_argument);
  EXPECT_THROW(SphereTree(cloud, -1), std::invalid_argument);
  EXPECT_THROW(SphereTree(cloud, 11), std::invalid_argument);
  EXPECT_THROW(SphereTree(PointCloud{}, 1), std::invalid_argument);
  EXPECT_NO_THROW(SphereTree(cloud, 10));
}

}  // namespace
}  // namespace thenar
