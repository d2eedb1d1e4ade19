// SPDX-License-Identifier: Apache-2.0
#include "collision/voronoi_cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "collision/point_cloud.h"
#include "collision/shapes.h"
#include "tests/support/scenes.h"

namespace thenar::voronoi_cells_test {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSphere = 4.0 * std::numbers::pi;

TEST(VoronoiCells, AreEqualOnAnOctahedron) {
  Matrix3Xd directions(3, 6);
  directions << Eigen::Matrix3d::Identity(), -Eigen::Matrix3d::Identity();
  // Equal by symmetry; rounding only.
  EXPECT_TRUE(voronoi_cells(directions).areas.isApproxToConstant(kSphere / 6.0, 1e-14));
}

TEST(VoronoiCells, OfOneDirectionIsTheSphere) { EXPECT_DOUBLE_EQ(voronoi_cells(Vector3d::UnitX()).areas[0], kSphere); }

// The share of many random directions that lie nearest: counted, c of them are right within 1/sqrt(c), four times which
// one in a thousand cells exceeds by chance. The plane's areas are right within 1 % of these small cells.
TEST(VoronoiCells, AreWhatCountingFinds) {
  constexpr Index kCells = 200, kSamples = 100'000;
  const Matrix3Xd directions = sample_sphere(1.0, kCells, 3).normals;
  std::mt19937_64 random(1);
  VectorXd counted = VectorXd::Zero(kCells);
  Matrix3Xd sum = Matrix3Xd::Zero(3, kCells);
  for (Index s = 0; s < kSamples; ++s) {
    Index nearest = 0;
    const Vector3d direction = random_direction(random);
    (directions.transpose() * direction).maxCoeff(&nearest);
    counted[nearest] += 1.0;
    sum.col(nearest) += direction;
  }
  const VoronoiCells cells = voronoi_cells(directions);
  const VectorXd& areas = cells.areas;
  EXPECT_NEAR(areas.sum(), kSphere, 1e-12);
  for (Index i = 0; i < kCells; ++i) {
    const double expected = kSphere * counted[i] / static_cast<double>(kSamples);
    EXPECT_NEAR(areas[i], expected, expected * (0.01 + 4.0 / std::sqrt(counted[i]))) << i;
    // Directions of a cell lie about as far from its middle as its area's root.
    const double scatter = std::sqrt(expected / counted[i]);
    EXPECT_LT((cells.centroids.col(i) - sum.col(i).normalized()).norm(), 4.0 * scatter) << i;
  }
}

}  // namespace
}  // namespace thenar::voronoi_cells_test
