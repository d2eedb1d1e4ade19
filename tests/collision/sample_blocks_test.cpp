// SPDX-License-Identifier: Apache-2.0
#include "collision/sample_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "collision/shapes.h"

namespace thenar::sample_blocks_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Nearest = SampleBlocks::Nearest;

class Random {
 public:
  explicit Random(unsigned seed) : bits_(seed) {}
  double between(double low, double high) { return low + (high - low) * static_cast<double>(bits_()) / 0x1p32; }
  Vector3d in_cube(double half) { return {between(-half, half), between(-half, half), between(-half, half)}; }

 private:
  std::mt19937 bits_;
};

PointCloud in_order(const PointCloud& cloud) {
  const std::vector<Index> order = SampleBlocks::order(cloud.points_m);
  return {cloud.points_m(Eigen::all, order), cloud.normals(Eigen::all, order)};
}

/// Clouds of one block, of full and of partly filled nodes; a lattice, where distances tie; a heap in one place.
std::vector<PointCloud> clouds() {
  std::vector<PointCloud> all;
  for (const Index count : {1, 7, 8, 9, 64, 65, 1000, 4097}) all.push_back(sample_sphere(8e-3, count));
  PointCloud lattice{Eigen::Matrix3Xd(3, 1000), Vector3d::UnitX().replicate(1, 1000)};
  for (int i = 0; i < 1000; ++i) lattice.points_m.col(i) = 1e-3 * Vector3d(i % 10, i / 10 % 10, i / 100);
  all.push_back(lattice);
  all.push_back({Eigen::Matrix3Xd::Constant(3, 30, 1e-3), Vector3d::UnitX().replicate(1, 30)});
  for (PointCloud& cloud : all) cloud = in_order(cloud);
  return all;
}

TEST(SampleBlocks, OrderIsAPermutationIntoFullBlocks) {
  for (const PointCloud& cloud : clouds()) {
    std::vector<Index> order = SampleBlocks::order(cloud.points_m);
    // The order of what is in order already is its own.
    EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
    const SampleBlocks blocks(cloud);
    EXPECT_EQ(static_cast<Index>(blocks.blocks().size()), (cloud.points_m.cols() + 7) / 8);
    for (Index i = 0; i < cloud.points_m.cols(); ++i) {
      EXPECT_EQ(blocks.blocks()[i / 8].point_m(static_cast<int>(i % 8)), cloud.points_m.col(i));
    }
  }
}

TEST(SampleBlocks, EveryBlockNearIsVisitedInOrder) {
  for (const PointCloud& cloud : clouds()) {
    const SampleBlocks blocks(cloud);
    for (unsigned seed = 1; seed <= 100; ++seed) {
      SCOPED_TRACE(testing::Message() << cloud.points_m.cols() << " points, seed " << seed);
      Random random(seed);
      const Vector3d c_m = random.in_cube(10e-3);
      const double radius_m = random.between(0.0, 10e-3);
      std::vector<Index> visited;
      blocks.for_each_near(c_m, radius_m, [&](const SampleBlocks::Block& block, Index number) {
        EXPECT_EQ(&block, &blocks.blocks()[number]);
        visited.push_back(number);
      });
      EXPECT_TRUE(std::is_sorted(visited.begin(), visited.end()));
      for (Index i = 0; i < cloud.points_m.cols(); ++i) {
        if ((cloud.points_m.col(i) - c_m).norm() > radius_m) continue;
        EXPECT_TRUE(std::binary_search(visited.begin(), visited.end(), i / 8));
      }
    }
  }
}

TEST(SampleBlocks, NearestIsExactWithAnyHint) {
  for (const PointCloud& cloud : clouds()) {
    const SampleBlocks blocks(cloud);
    const Index count = cloud.points_m.cols();
    int free_ones = 0;
    for (unsigned seed = 1; seed <= 200; ++seed) {
      SCOPED_TRACE(testing::Message() << count << " points, seed " << seed);
      Random random(seed);
      // Every fourth on a lattice of half steps: there up to eight samples of the lattice are equally near.
      Vector3d x_m = random.in_cube(12e-3);
      if (seed % 4 == 0) x_m = (x_m / 0.5e-3).array().round() * 0.5e-3;
      const double reach_m = random.between(1e-3, 10e-3), beyond_m = seed % 2 == 0 ? 0.0 : 0.3e-3;

      const Eigen::VectorXd d_m = (cloud.points_m.colwise() - x_m).colwise().norm();
      const Nearest found = blocks.nearest(x_m, reach_m, beyond_m);
      // To rounding: the squares are summed in another order.
      const double least_m = d_m.minCoeff(), rounding_m = 1e-15;
      if (found.sample < 0) {
        EXPECT_GT(least_m, reach_m - rounding_m);
        EXPECT_LE(found.distance_m, least_m + rounding_m);
        EXPECT_GE(found.distance_m, reach_m);
      } else {
        EXPECT_LE(least_m, reach_m + rounding_m);
        EXPECT_NEAR(d_m[found.sample], least_m, rounding_m);
        EXPECT_NEAR(found.distance_m, least_m, rounding_m);
        double free_m = 0.5 * beyond_m;
        for (Index j = 0; j < count; ++j) {
          const double apart_m = (cloud.points_m.col(j) - cloud.points_m.col(found.sample)).norm();
          const double farther_m2 = d_m[j] * d_m[j] - least_m * least_m;
          if (apart_m > 0.0) free_m = std::min(free_m, 0.5 * farther_m2 / apart_m);
        }
        // 0: a heap of samples is as near as this one. Rounding of squares, over samples 10 um apart and more.
        if (found.free_m > 0.0) {
          EXPECT_NEAR(found.free_m, free_m, 1e-13);
          ++free_ones;
        }
        for (int k = 0; k < 5 && found.free_m > 0.0; ++k) {
          const Vector3d moved_m = x_m + 0.999 * found.free_m * random.in_cube(1.0).normalized();
          EXPECT_EQ(blocks.nearest(moved_m, 1.0).sample, found.sample) << "it is not free to move";
        }
      }
      for (int k = 0; k < 5; ++k) {
        const Index hint =
            std::min<Index>(count - 1, static_cast<Index>(random.between(0.0, 1.0) * static_cast<double>(count)));
        EXPECT_EQ(blocks.nearest(x_m, reach_m, beyond_m, hint).sample, found.sample);
      }
      EXPECT_EQ(blocks.nearest(x_m, reach_m, 5e-3).sample, found.sample);
    }
    EXPECT_GE(free_ones, 8);
  }
}

TEST(SampleBlocks, TiesGoByNumber) {
  const PointCloud heap{Eigen::Matrix3Xd::Constant(3, 30, 1e-3), Vector3d::UnitX().replicate(1, 30)};
  const SampleBlocks blocks(heap);
  for (Index hint = -1; hint < 30; ++hint) {
    const Nearest found = blocks.nearest({2e-3, 0.0, 1e-3}, 5e-3, 0.0, hint);
    EXPECT_EQ(found.sample, 0);
  }
}

}  // namespace
}  // namespace thenar::sample_blocks_test
