// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/surface_display.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace thenar::surface_display_test {
namespace {

using Eigen::Index;
using Eigen::MatrixX3d;
using Eigen::Vector3d;

class Display : public testing::TestWithParam<Index> {
 protected:
  Pulp pulp = make_spherical_pulp(Vector3d(1e-3, 2e-3, 3e-3), 8e-3, 1203, GetParam(), {0.24e6, 0.5, 2e-3});
  SurfaceDisplay display{pulp};
};

// The weights of every sample sum to 1: a pulp that moves as a whole is shown moved as a whole, the other way of u.
TEST_P(Display, ShowsARigidMotionExactly) {
  const Vector3d u(1e-3, -2e-3, 0.5e-3);
  const Eigen::MatrixX3f shown = display.displace(u.transpose().replicate(pulp.controls(), 1));
  ASSERT_EQ(shown.rows(), 1203);
  // Ten roundings of weights and products, in single precision.
  EXPECT_LE((shown.cast<double>().rowwise() + u.transpose()).cwiseAbs().maxCoeff(), 20 * 1.2e-7 * u.norm());
}

// Weights are not negative: no sample is shown beyond what its control points do, in any direction.
TEST_P(Display, StaysWithinTheControlPointsDisplacements) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    MatrixX3d u(pulp.controls(), 3);
    for (Index i = 0; i < u.rows(); ++i) u.row(i) = 1e-3 * random_direction(random).transpose();
    const Eigen::MatrixX3f shown = display.displace(u);
    const double rounding = 20 * 1.2e-7 * 1e-3;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(shown.col(axis).maxCoeff(), -u.col(axis).minCoeff() + rounding);
      EXPECT_GE(shown.col(axis).minCoeff(), -u.col(axis).maxCoeff() - rounding);
    }
  }
}

// Only the nearest control points count: one that moves is seen about it, most at the samples nearest to it, and
// nowhere on the far side.
TEST_P(Display, IsLocal) {
  if (pulp.controls() < 100) return;
  MatrixX3d u = MatrixX3d::Zero(pulp.controls(), 3);
  u(7, 0) = -1.0;
  const Eigen::MatrixX3f shown = display.displace(u);
  const auto distance = [&](Index row) {
    return (pulp.surface.points_m.col(pulp.order[row]) - pulp.control_points_m.col(7)).norm();
  };
  const double spacing = std::sqrt(pulp.area_m2.mean());
  for (Index i = 0; i < shown.rows(); ++i) {
    // Ten nearest of an even spread reach 1.8 spacings; unevenness stays below twice that.
    if (distance(i) > 4.0 * spacing) {
      EXPECT_EQ(shown(i, 0), 0.0);
    }
    // The ten have weights of at most that of the nearest, which the control point is to itself.
    if (distance(i) == 0.0) {
      EXPECT_GE(shown(i, 0), 0.1);
    }
  }
}

// Eq. (27) itself, sample by sample, in double precision.
TEST_P(Display, IsTheWeightedMeanOfTheTenNearest) {
  std::mt19937_64 random(9);
  MatrixX3d u(pulp.controls(), 3);
  for (Index i = 0; i < u.rows(); ++i) u.row(i) = 1e-3 * random_direction(random).transpose();
  const Eigen::MatrixX3f shown = display.displace(u);
  for (Index row = 0; row < shown.rows(); ++row) {
    const Vector3d p = pulp.surface.points_m.col(pulp.order[row]);
    std::vector<std::pair<double, Index>> nearest;
    for (Index c = 0; c < pulp.controls(); ++c) nearest.emplace_back((pulp.control_points_m.col(c) - p).norm(), c);
    std::sort(nearest.begin(), nearest.end());
    nearest.resize(std::min<std::size_t>(10, nearest.size()));
    Vector3d sum = Vector3d::Zero();
    double weights = 0.0;
    for (const auto& [d, c] : nearest) {
      const double w = std::exp(-d * d / (2.0 * pulp.area_m2.mean()));
      sum -= w * u.row(c).transpose();
      weights += w;
    }
    EXPECT_LE((shown.row(row).transpose().cast<double>() - sum / weights).norm(), 20 * 1.2e-7 * 1e-3);
  }
}

TEST_P(Display, DoesNotAllocate) {
  const MatrixX3d u = MatrixX3d::Random(pulp.controls(), 3);
  const AllocationCounter counter;
  display.displace(u);
  EXPECT_EQ(counter.count(), 0);
}

// 160 control points as usual; 4 are fewer than the neighbours that a sample looks for.
INSTANTIATE_TEST_SUITE_P(ControlPoints, Display, testing::Values(160, 4));

}  // namespace
}  // namespace thenar::surface_display_test
