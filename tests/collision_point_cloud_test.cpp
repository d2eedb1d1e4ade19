#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

const Vector3d kBox_m(50e-3, 50e-3, 100e-3);

/// Distance between neighbours if `count` samples were packed hexagonally: the most that is possible in a plane.
double hexagonal_m(double area_m2, Index count) {
  return std::sqrt(2.0 * area_m2 / (std::sqrt(3.0) * static_cast<double>(count)));
}

double box_area_m2(const Vector3d& size_m) {
  return 2.0 * (size_m.x() * size_m.y() + size_m.y() * size_m.z() + size_m.z() * size_m.x());
}

double least_distance_m(const PointCloud& cloud) {
  double least = std::numeric_limits<double>::infinity();
  for (Index i = 0; i + 1 < cloud.points_m.cols(); ++i) {
    const auto others = cloud.points_m.rightCols(cloud.points_m.cols() - i - 1);
    least = std::min(least, (others.colwise() - cloud.points_m.col(i)).colwise().squaredNorm().minCoeff());
  }
  return std::sqrt(least);
}

/// Faces 0..5 = x-, x+, y-, y+, z-, z+; -1 if the sample is not exactly on the face that its normal names.
int face_of(const PointCloud& cloud, Index i, const Vector3d& size_m) {
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const double side = face % 2 == 0 ? -1.0 : 1.0;
    if (cloud.normals.col(i) != side * Vector3d::Unit(axis)) continue;
    const Vector3d p = cloud.points_m.col(i);
    const bool inside = (p.cwiseAbs().array() <= 0.5 * size_m.array()).all();
    return inside && p[axis] == side * 0.5 * size_m[axis] ? face : -1;
  }
  return -1;
}

TEST(PointCloud, BoxSamplesLieOnFacesWithTheFacesNormals) {
  for (const Index count : {1, 2, 7, 100, 4000}) {
    SCOPED_TRACE(count);
    const PointCloud cloud = sample_box(kBox_m, count);
    ASSERT_EQ(cloud.points_m.cols(), count);
    ASSERT_EQ(cloud.normals.cols(), count);
    for (Index i = 0; i < count; ++i) ASSERT_GE(face_of(cloud, i, kBox_m), 0);
  }
}

TEST(PointCloud, SphereSamplesLieOnTheSphere) {
  const double radius_m = 8e-3;
  for (const Index count : {1, 2, 7, 100, 2400}) {
    SCOPED_TRACE(count);
    const PointCloud cloud = sample_sphere(radius_m, count);
    ASSERT_EQ(cloud.points_m.cols(), count);
    ASSERT_EQ(cloud.normals.cols(), count);
    // A normalised vector has a norm of 1 to a few roundings.
    for (Index i = 0; i < count; ++i) ASSERT_NEAR(cloud.normals.col(i).norm(), 1.0, 1e-15);
    ASSERT_EQ(cloud.points_m, radius_m * cloud.normals);
  }
}

TEST(PointCloud, SamplesKeepTheirDistance) {
  // Sample elimination is known to reach 0.65-0.8 of the hexagonal packing [Yuksel 2015]; uniform random samples of
  // this number come as close as 0.01.
  EXPECT_GE(least_distance_m(sample_box(kBox_m, 4000)), 0.65 * hexagonal_m(box_area_m2(kBox_m), 4000));
  const double radius_m = 8e-3;
  EXPECT_GE(least_distance_m(sample_sphere(radius_m, 2400)),
            0.65 * hexagonal_m(4.0 * std::numbers::pi * radius_m * radius_m, 2400));
}

TEST(PointCloud, TheTwoSidesOfAPlateAreSampledApart) {
  const Vector3d plate_m(50e-3, 0.5e-3, 50e-3);
  const PointCloud cloud = sample_box(plate_m, 4000);
  PointCloud top;
  std::vector<Index> on_top;
  for (Index i = 0; i < 4000; ++i) {
    if (face_of(cloud, i, plate_m) == 3) on_top.push_back(i);
  }
  top = {cloud.points_m(Eigen::all, on_top), cloud.normals(Eigen::all, on_top)};
  // If the sides crowded each other, each would be a random half of a blue noise, and pairs of about 0.3 would survive.
  EXPECT_GE(least_distance_m(top), 0.6 * hexagonal_m(box_area_m2(plate_m), 4000));
}

TEST(PointCloud, BoxFacesGetSamplesByArea) {
  const Index count = 9000;
  const PointCloud cloud = sample_box(kBox_m, count);
  std::array<double, 6> samples{};
  for (Index i = 0; i < count; ++i) ++samples.at(face_of(cloud, i, kBox_m));
  for (int face = 0; face < 6; ++face) {
    const double expected = static_cast<double>(count) * kBox_m.prod() / kBox_m[face / 2] / box_area_m2(kBox_m);
    // Blue noise varies only along the rim of the area: some tenths of the 120-180 samples that line a face. Random
    // samples would vary by sqrt(count): 30-40.
    EXPECT_NEAR(samples.at(face), expected, 20.0) << "face " << face;
  }
}

TEST(PointCloud, BoxIsSampledUpToTheEdges) {
  // The share of the samples within one spacing of an edge against the share of the area there.
  const Index count = 9000;
  const double strip_m = std::sqrt(box_area_m2(kBox_m) / static_cast<double>(count));
  const PointCloud cloud = sample_box(kBox_m, count);
  double near_edge = 0.0;
  for (Index i = 0; i < count; ++i) {
    Vector3d to_faces_m = 0.5 * kBox_m - cloud.points_m.col(i).cwiseAbs();
    to_faces_m[face_of(cloud, i, kBox_m) / 2] = std::numeric_limits<double>::infinity();
    if (to_faces_m.minCoeff() < strip_m) ++near_edge;
  }
  const Vector3d inner_m = kBox_m.array() - 2.0 * strip_m;
  const double expected = static_cast<double>(count) * (1.0 - box_area_m2(inner_m) / box_area_m2(kBox_m));
  // Around an edge the straight distance is shorter than the way over the faces, so the edge looks a little more
  // crowded than it is. Ignoring the other face, or clipping at the edge, would give a tenth more or less.
  EXPECT_NEAR(near_edge / expected, 1.0, 0.06);
}

TEST(PointCloud, SphereIsSampledByArea) {
  const Index count = 8000;
  const PointCloud cloud = sample_sphere(1.0, count);
  std::array<double, 8> in_octant{}, in_band{};
  for (Index i = 0; i < count; ++i) {
    const Vector3d p = cloud.points_m.col(i);
    ++in_octant.at((p.x() > 0 ? 1U : 0U) + (p.y() > 0 ? 2U : 0U) + (p.z() > 0 ? 4U : 0U));
    ++in_band.at(static_cast<std::size_t>(std::min(4.0 * (p.z() + 1.0), 7.0)));  // equal heights have equal areas
  }
  // Some tenths of the 120 samples that line an octant, and of the 320 around a band; random samples vary by 30.
  for (const double n : in_octant) EXPECT_NEAR(n, 1000.0, 20.0);
  for (const double n : in_band) EXPECT_NEAR(n, 1000.0, 25.0);
}

TEST(PointCloud, SameSeedSameCloud) {
  const PointCloud box = sample_box(kBox_m, 500, 7), sphere = sample_sphere(8e-3, 500, 7);
  EXPECT_EQ(box.points_m, sample_box(kBox_m, 500, 7).points_m);
  EXPECT_EQ(sphere.points_m, sample_sphere(8e-3, 500, 7).points_m);
  EXPECT_NE(box.points_m, sample_box(kBox_m, 500, 8).points_m);
  EXPECT_NE(sphere.points_m, sample_sphere(8e-3, 500, 8).points_m);
}

TEST(PointCloud, RefusesWhatHasNoSurface) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)sample_box({1.0, 0.0, 1.0}, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_box({1.0, nan, 1.0}, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_box({1.0, 1.0, 1.0}, 0), std::invalid_argument);
  EXPECT_THROW((void)sample_sphere(-1.0, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_sphere(nan, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_sphere(1.0, 0), std::invalid_argument);
}

}  // namespace
}  // namespace thenar
