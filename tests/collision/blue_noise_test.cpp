// SPDX-License-Identifier: Apache-2.0
#include "collision/blue_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "collision/shapes.h"
#include "tests/collision/box_samples.h"

namespace thenar::blue_noise_test {
namespace {

using namespace box_samples;

/// Distance between neighbours if `count` samples were packed hexagonally: the most that is possible in a plane.
double hexagonal_m(double area_m2, Index count) {
  return std::sqrt(2.0 * area_m2 / (std::sqrt(3.0) * static_cast<double>(count)));
}

double least_distance_m(const PointCloud& cloud) {
  double least = std::numeric_limits<double>::infinity();
  for (Index i = 0; i + 1 < cloud.points_m.cols(); ++i) {
    const auto others = cloud.points_m.rightCols(cloud.points_m.cols() - i - 1);
    least = std::min(least, (others.colwise() - cloud.points_m.col(i)).colwise().squaredNorm().minCoeff());
  }
  return std::sqrt(least);
}

TEST(Shapes, SamplesKeepTheirDistance) {
  // Sample elimination is known to reach 0.65-0.8 of the hexagonal packing [Yuksel 2015]; uniform random samples of
  // this number come as close as 0.01.
  EXPECT_GE(least_distance_m(sample_box(kBox_m, 4000)), 0.65 * hexagonal_m(box_area_m2(kBox_m), 4000));
  const double radius_m = 8e-3;
  EXPECT_GE(least_distance_m(sample_sphere(radius_m, 2400)),
            0.65 * hexagonal_m(4.0 * std::numbers::pi * radius_m * radius_m, 2400));
}

TEST(Shapes, TheTwoSidesOfAPlateAreSampledApart) {
  const Vector3d plate_m(50e-3, 0.5e-3, 50e-3);
  const PointCloud cloud = sample_box(plate_m, 4000);
  PointCloud top;
  std::vector<Index> on_top;
  for (Index i = 0; i < 3000; ++i) {
    if (face_of(cloud, i, plate_m) == 3) on_top.push_back(i);
  }
  top = {cloud.points_m(Eigen::all, on_top), cloud.normals(Eigen::all, on_top)};
  // If the sides crowded each other, each would be a random half of a blue noise, and pairs of about 0.3 would survive.
  EXPECT_GE(least_distance_m(top), 0.6 * hexagonal_m(box_area_m2(plate_m), 4000));
}

}  // namespace
}  // namespace thenar::blue_noise_test
