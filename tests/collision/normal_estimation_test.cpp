// SPDX-License-Identifier: Apache-2.0
#include "collision/normal_estimation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "collision/shapes.h"

namespace thenar::normal_estimation_test {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr double kMm = 1e-3;

struct NormalErrors {
  double turned_share, mean_deg;
};

NormalErrors errors_on(const PointCloud& cloud) {
  PointCloud estimated{cloud.points_m, {}};
  estimate_normals(estimated);
  const Eigen::ArrayXd cosines = (estimated.normals.array() * cloud.normals.array()).colwise().sum();
  EXPECT_LT((estimated.normals.colwise().norm().array() - 1.0).abs().maxCoeff(), 1e-12);
  return {(cosines < 0.0).cast<double>().mean(), cosines.abs().min(1.0).acos().mean() * 180.0 / std::numbers::pi};
}

TEST(NormalEstimation, SphereAndBoxAndPlate) {
  // Planes through a sample and its neighbours are exact on faces; samples within 0.3 spacings of an edge may take the
  // other face or the middle. On a sphere a lopsided neighbourhood tilts the plane by a tenth of its radius over R.
  const NormalErrors sphere = errors_on(sample_sphere(20 * kMm, 8000));
  EXPECT_EQ(sphere.turned_share, 0.0);
  EXPECT_LT(sphere.mean_deg, 2.0);
  const NormalErrors box = errors_on(sample_box({50 * kMm, 50 * kMm, 50 * kMm}, 20000));
  EXPECT_LT(box.turned_share, 0.001);
  EXPECT_LT(box.mean_deg, 2.0);
  const NormalErrors plate = errors_on(sample_box({50 * kMm, 2 * kMm, 100 * kMm}, 20600));
  EXPECT_LT(plate.turned_share, 0.001);
  EXPECT_LT(plate.mean_deg, 2.5);
}

TEST(NormalEstimation, CupsAreOutwardInsideToo) {
  // A cup of radius 20 mm, height 30 mm and wall 3 mm: outer and inner wall, rim, both sides of the floor.
  std::vector<Vector3d> points_m, normals;
  const double step_m = 0.7 * kMm;
  int rings = 0;
  const auto ring = [&](double radius_m, double z_m, double n_r, double n_z) {
    const double count = std::floor(2.0 * std::numbers::pi * radius_m / step_m) + 1.0;
    ++rings;
    for (double k = 0.0; k < count; ++k) {
      const double turn = 2.0 * std::numbers::pi * (k + 0.382 * rings) / count;
      const Vector3d u(std::cos(turn), std::sin(turn), 0.0);
      points_m.push_back(radius_m * u + z_m * Vector3d::UnitZ());
      normals.push_back(n_r * u + n_z * Vector3d::UnitZ());
    }
  };
  for (double z_m = 0.5 * step_m; z_m < 30 * kMm; z_m += step_m) ring(20 * kMm, z_m, 1.0, 0.0);
  for (double z_m = 3 * kMm + 0.5 * step_m; z_m < 30 * kMm; z_m += step_m) ring(17 * kMm, z_m, -1.0, 0.0);
  for (double r_m = 17 * kMm + 0.5 * step_m; r_m < 20 * kMm; r_m += step_m) ring(r_m, 30 * kMm, 0.0, 1.0);
  for (double r_m = 0.5 * step_m; r_m < 20 * kMm; r_m += step_m) ring(r_m, 0.0, 0.0, -1.0);
  for (double r_m = 0.5 * step_m; r_m < 17 * kMm; r_m += step_m) ring(r_m, 3 * kMm, 0.0, 1.0);
  PointCloud cup{Matrix3Xd(3, points_m.size()), Matrix3Xd(3, points_m.size())};
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    cup.points_m.col(static_cast<Index>(i)) = points_m[i];
    cup.normals.col(static_cast<Index>(i)) = normals[i];
  }
  const NormalErrors errors = errors_on(cup);
  EXPECT_LT(errors.turned_share, 0.005);  // those on an edge, whose normal lies between two faces
  EXPECT_LT(errors.mean_deg, 4.0);
}

// A scanner sees one side better: below the middle one sample in `ratio` is left, by chance. A box loses the samples
// that tell its edges; on a ball every sign is known.
TEST(NormalEstimation, ScansThatAreSparseOnOneSide) {
  const PointCloud ball = sample_sphere(25 * kMm, 20000), box = sample_box({50 * kMm, 40 * kMm, 60 * kMm}, 20000);
  for (const int ratio : {2, 5, 10, 30}) {
    SCOPED_TRACE(ratio);
    std::mt19937 bits(ratio);
    const auto thinned = [&](const PointCloud& cloud) {
      PointCloud left = cloud;
      Index kept = 0;
      for (Index i = 0; i < cloud.points_m.cols(); ++i) {
        if (cloud.points_m(2, i) < 0.0 && bits() % ratio != 0) continue;
        left.points_m.col(kept) = cloud.points_m.col(i);
        left.normals.col(kept++) = cloud.normals.col(i);
      }
      left.points_m.conservativeResize(3, kept);
      left.normals.conservativeResize(3, kept);
      return left;
    };
    const NormalErrors of_ball = errors_on(thinned(ball)), of_box = errors_on(thinned(box));
    EXPECT_EQ(of_ball.turned_share, 0.0);
    EXPECT_LT(of_ball.mean_deg, 3.0);
    EXPECT_LT(of_box.turned_share, 0.005);
    EXPECT_LT(of_box.mean_deg, 5.0);
  }
}

TEST(NormalEstimation, SameCloudSameNormals) {
  const PointCloud cloud = sample_sphere(8 * kMm, 1000);
  PointCloud once{cloud.points_m, {}}, again{cloud.points_m, cloud.normals};
  estimate_normals(once);
  estimate_normals(again);
  EXPECT_EQ(once.normals, again.normals);
}

TEST(NormalEstimation, SeparatePartsAreAllOutward) {
  const PointCloud ball = sample_sphere(8 * kMm, 1000);
  PointCloud two{Matrix3Xd(3, 2000), Matrix3Xd(3, 2000)};
  two.points_m << ball.points_m, ball.points_m.colwise() + Vector3d(30 * kMm, 0, 0);
  two.normals << ball.normals, ball.normals;
  EXPECT_EQ(errors_on(two).turned_share, 0.0);
}

// A constant, axes in another order, and vectors of another kind against those of the surface, also turned inward.
TEST(NormalEstimation, TellsNormalsFromOtherVectors) {
  for (PointCloud cloud : {sample_sphere(25 * kMm, 3000), sample_box({50 * kMm, 50 * kMm, 50 * kMm}, 8000)}) {
    EXPECT_LT(share_off_planes(cloud), 0.05);
    const Matrix3Xd own = cloud.normals;
    cloud.normals = -own;
    EXPECT_LT(share_off_planes(cloud), 0.05);
    cloud.normals << own.row(1), own.row(2), own.row(0);
    EXPECT_GT(share_off_planes(cloud), 0.6);
    cloud.normals.colwise() = Vector3d::UnitZ();
    EXPECT_GT(share_off_planes(cloud), 0.6);
  }
}

TEST(NormalEstimation, RefusesWhatHasNoSpacing) {
  PointCloud one{Vector3d::Zero(), {}}, same_place{Matrix3Xd::Zero(3, 20), {}};
  EXPECT_THROW(estimate_normals(one), std::invalid_argument);
  EXPECT_THROW(estimate_normals(same_place), std::invalid_argument);
}

}  // namespace
}  // namespace thenar::normal_estimation_test
