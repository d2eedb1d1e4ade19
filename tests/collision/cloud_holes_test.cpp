// SPDX-License-Identifier: Apache-2.0
#include "collision/cloud_holes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "collision/cloud_repair.h"
#include "collision/shapes.h"

namespace thenar::cloud_holes_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kMm = 1e-3;
constexpr double kLargest_m = 8 * kMm;

PointCloud subset(const PointCloud& cloud, const std::function<bool(Index)>& keep) {
  std::vector<Index> kept;
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    if (keep(i)) kept.push_back(i);
  }
  return {cloud.points_m(Eigen::all, kept), cloud.normals(Eigen::all, kept)};
}

PointCloud torn(const PointCloud& cloud, const Vector3d& centre_m, double radius_m) {
  return subset(cloud, [&](Index i) { return (cloud.points_m.col(i) - centre_m).norm() > radius_m; });
}

const PointCloud& box() {
  static const PointCloud kBox = sample_box({50 * kMm, 50 * kMm, 50 * kMm}, 21700);  // spacing 0.83 mm, h = 1.83 mm
  return kBox;
}

TEST(CloudHoles, WholeSurfacesHaveNone) {
  PointCloud room = sample_box({10 * kMm, 10 * kMm, 10 * kMm}, 6000);
  room.normals *= -1.0;
  std::vector<PointCloud> clouds = {box(), room, sample_sphere(8 * kMm, 2400), sample_sphere(8 * kMm, 150)};
  for (const double thickness_mm : {2.0, 1.0})
    clouds.push_back(sample_box({30 * kMm, thickness_mm * kMm, 50 * kMm}, 6000));
  for (const PointCloud& cloud : clouds) EXPECT_TRUE(find_holes(cloud, covering_support_m(cloud), kLargest_m).empty());
}

TEST(CloudHoles, ThinAndNoisyCloudsHaveNone) {
  std::mt19937 bits(3);
  std::normal_distribution<double> noise_m(0.0, 0.2 * kMm);
  const PointCloud thin = subset(box(), [&](Index) { return bits() % 4 == 0; });
  const PointCloud uneven = subset(box(), [&](Index i) { return box().points_m(2, i) < 0.0 || bits() % 4 == 0; });
  PointCloud noisy = box();
  for (double& coordinate : noisy.points_m.reshaped()) coordinate += noise_m(bits);
  for (PointCloud cloud : {thin, uneven, noisy}) {
    const double h_m = covering_support_m(cloud);
    repair(cloud, h_m);
    EXPECT_TRUE(find_holes(cloud, h_m, kLargest_m).empty());
  }
}

TEST(CloudHoles, SaysWhereAndHowWide) {
  for (const double radius_mm : {2.5, 4.0, 6.0}) {
    for (const Vector3d& centre_m : {Vector3d(3, 25, 5), Vector3d(25, 25, 3)}) {
      SCOPED_TRACE(testing::Message() << "radius " << radius_mm << " mm at " << centre_m.transpose());
      const PointCloud cloud = torn(box(), kMm * centre_m, radius_mm * kMm);
      const auto holes = find_holes(cloud, 1.83 * kMm, kLargest_m);
      ASSERT_EQ(holes.size(), 1U);
      // The rim is known to a spacing, and the ball touches one of its samples on one side.
      EXPECT_NEAR(holes[0].radius_m, radius_mm * kMm, 0.83 * kMm);
      EXPECT_LT((holes[0].centre_m - kMm * centre_m).norm(), 1.5 * kMm);
    }
  }
}

TEST(CloudHoles, HolesNarrowerThanTheSupportAreNone) {
  EXPECT_TRUE(find_holes(torn(box(), {0.0, 25 * kMm, 0.0}, 1 * kMm), 1.83 * kMm, kLargest_m).empty());
}

TEST(CloudHoles, CountsThemLargestFirst) {
  const PointCloud cloud = torn(torn(box(), {0.0, 25 * kMm, 0.0}, 3 * kMm), {0.0, 0.0, 25 * kMm}, 5 * kMm);
  const auto holes = find_holes(cloud, 1.83 * kMm, kLargest_m);
  ASSERT_EQ(holes.size(), 2U);
  EXPECT_GT(holes[0].centre_m.z(), 20 * kMm);
  EXPECT_GT(holes[1].centre_m.y(), 20 * kMm);
}

TEST(CloudHoles, AnOpenBoxIsAHoleAsWideAsIsLookedFor) {
  const PointCloud open = subset(box(), [](Index i) { return box().normals(2, i) < 0.5; });
  const auto holes = find_holes(open, 1.83 * kMm, kLargest_m);
  ASSERT_FALSE(holes.empty());
  EXPECT_EQ(holes[0].radius_m, kLargest_m);
}

}  // namespace
}  // namespace thenar::cloud_holes_test
