// SPDX-License-Identifier: Apache-2.0
#include "collision/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <stdexcept>
#include <vector>

#include "collision/implicit_surface.h"
#include "tests/collision/box_samples.h"

namespace thenar::shapes_test {
namespace {

using namespace box_samples;

TEST(Shapes, BoxSamplesLieOnFacesWithTheFacesNormals) {
  for (const Index count : {1, 2, 7, 100, 4000}) {
    SCOPED_TRACE(count);
    const PointCloud cloud = sample_box(kBox_m, count);
    ASSERT_EQ(cloud.points_m.cols(), count);
    ASSERT_EQ(cloud.normals.cols(), count);
    for (Index i = 0; i < count; ++i) ASSERT_GE(face_of(cloud, i, kBox_m), 0);
  }
}

TEST(Shapes, SphereSamplesLieOnTheSphere) {
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

TEST(Shapes, BoxFacesGetSamplesByArea) {
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

TEST(Shapes, BoxIsSampledUpToTheEdges) {
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

TEST(Shapes, SphereIsSampledByArea) {
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

/// A solid's field near its surface, < 0 inside, and the surface's normal where the field is zero.
struct Field {
  double f_m;
  Vector3d n;
};

Field both(const Field& a, const Field& b) { return a.f_m > b.f_m ? a : b; }
Field either(const Field& a, const Field& b) { return a.f_m < b.f_m ? a : b; }
Field without(const Field& a, const Field& b) { return both(a, {-b.f_m, -b.n}); }

Field cylinder_field(double radius_m, double low_m, double high_m, const Vector3d& p_m) {
  const Vector3d radial(p_m.x(), p_m.y(), 0.0);
  const Field side{radial.norm() - radius_m, radial.normalized()};
  return both(side, both({p_m.z() - high_m, Vector3d::UnitZ()}, {low_m - p_m.z(), -Vector3d::UnitZ()}));
}

Field mug_field(const Mug& mug, const Vector3d& p_m) {
  const double end_m = 0.5 * mug.height_m;
  const Field cup = without(cylinder_field(mug.radius_m, -end_m, end_m, p_m),
                            cylinder_field(mug.radius_m - mug.wall_m, mug.wall_m - end_m, 2.0 * end_m, p_m));
  if (!mug.handle) return cup;
  const Vector3d in_ring = Vector3d(p_m.x() - mug.radius_m, 0.0, p_m.z());
  const Vector3d from_rod = Vector3d(0.0, p_m.y(), 0.0) + in_ring - mug.handle->radius_m * in_ring.normalized();
  const Field rod{from_rod.norm() - 0.5 * mug.handle->thickness_m, from_rod.normalized()};
  return either(cup, without(rod, cylinder_field(mug.radius_m, -end_m, end_m, p_m)));
}

/// Barr's inside-outside function to the power e1/2, minus 1: the relative way past the surface as seen from the
/// centre.
Field superquadric_field(const Vector3d& size_m, const Exponents& e, const Vector3d& p_m) {
  const double e1 = e.north_south, e2 = e.east_west;
  const Vector3d u = 2.0 * p_m.cwiseQuotient(size_m), a = u.cwiseAbs();
  const double xy = std::pow(a.x(), 2.0 / e2) + std::pow(a.y(), 2.0 / e2);
  const double f = std::pow(xy, e2 / e1) + std::pow(a.z(), 2.0 / e1);
  const double equator = std::pow(xy, e2 / e1 - 1.0);
  Vector3d n(equator * std::pow(a.x(), 2.0 / e2 - 1.0), equator * std::pow(a.y(), 2.0 / e2 - 1.0),
             std::pow(a.z(), 2.0 / e1 - 1.0));
  n = n.cwiseProduct(u.cwiseSign()).cwiseQuotient(size_m).normalized();
  return {(std::pow(f, 0.5 * e1) - 1.0) * 0.5 * size_m.minCoeff(), n};
}

const Mug kMug{15e-3, 34e-3, 4e-3, MugHandle{9e-3, 6e-3}};

/// A shape, how it is sampled, and its field.
struct Solid {
  const char* name;
  std::function<PointCloud(Index count, std::uint32_t seed)> sample;
  std::function<Field(const Vector3d& p_m)> field;
};

Solid superquadric(const char* name, const Vector3d& size_m, const Exponents& e) {
  return {name, [=](Index count, std::uint32_t seed) { return sample_superquadric(size_m, e, count, seed); },
          [=](const Vector3d& p_m) { return superquadric_field(size_m, e, p_m); }};
}

std::vector<Solid> solids() {
  const Vector3d size_m(24e-3, 36e-3, 90e-3);
  return {{"ellipsoid", [=](Index count, std::uint32_t seed) { return sample_ellipsoid(size_m, count, seed); },
           [=](const Vector3d& p_m) {
             return superquadric_field(size_m, {1.0, 1.0}, p_m);
           }},
          {"cylinder", [](Index count, std::uint32_t seed) { return sample_cylinder(12e-3, 90e-3, count, seed); },
           [](const Vector3d& p_m) { return cylinder_field(12e-3, -45e-3, 45e-3, p_m); }},
          superquadric("handle of a screwdriver", size_m, {0.3, 1.0}),
          superquadric("almost a box", size_m, {0.1, 0.1}),
          superquadric("almost an octahedron", size_m, {2.0, 2.0}),
          superquadric("pillow", size_m, {1.3, 0.5}),
          {"mug", [](Index count, std::uint32_t seed) { return sample_mug(kMug, count, seed); },
           [](const Vector3d& p_m) { return mug_field(kMug, p_m); }},
          {"cup",
           [](Index count, std::uint32_t seed) {
             return sample_mug({12e-3, 30e-3, 3e-3, {}}, count, seed);
           },
           [](const Vector3d& p_m) {
             return mug_field({12e-3, 30e-3, 3e-3, {}}, p_m);
           }}};
}

TEST(Shapes, SamplesLieOnTheSolidsBoundaryWithItsNormals) {
  // The field of a union is zero on its boundary alone: no sample of the mug's wall is inside its handle, nor the
  // other way round.
  for (const Solid& solid : solids()) {
    for (const Index count : {1, 7, 3000}) {
      SCOPED_TRACE(solid.name);
      const PointCloud cloud = solid.sample(count, 1);
      ASSERT_EQ(cloud.points_m.cols(), count);
      ASSERT_EQ(cloud.normals.cols(), count);
      const double size_m = cloud.points_m.cwiseAbs().maxCoeff();
      for (Index i = 0; i < count; ++i) {
        const Field field = solid.field(cloud.points_m.col(i));
        // Some tens of roundings: powers of up to 20 multiply those of their base.
        ASSERT_NEAR(field.f_m, 0.0, 1e-12 * size_m);
        ASSERT_NEAR(cloud.normals.col(i).norm(), 1.0, 1e-15);
        ASSERT_LT((cloud.normals.col(i) - field.n).norm(), 1e-12) << cloud.points_m.col(i).transpose();
      }
    }
  }
}

TEST(Shapes, ClosedSurfacesHaveNoNetNormal) {
  // The integral of the normal over a closed surface is zero. Samples of equal area leave the noise of those along the
  // edges, some hundreds of the 3000; without a rim, floor or cap the mean would be 0.015 to 0.2.
  for (const Solid& solid : solids()) {
    SCOPED_TRACE(solid.name);
    EXPECT_LT(solid.sample(3000, 1).normals.rowwise().mean().norm(), 0.01);
  }
}

/// A superquadric's area by bins: of the bands between heights, which are sections of its profile times sections of its
/// outline.
std::array<double, 16> area_by_bins(const Vector3d& size_m, const Exponents& e, auto bins_of) {
  constexpr int kSteps = 200;
  const auto at = [&](int i, int j) {
    const double z = 2.0 * static_cast<double>(i) / kSteps - 1.0;
    const double across = std::pow(1.0 - std::pow(std::abs(z), 2.0 / e.north_south), 0.5 * e.north_south);
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(j) / kSteps;
    const double c = std::cos(angle), s = std::sin(angle), power = 2.0 / e.east_west;
    const double r = std::pow(std::pow(std::abs(c), power) + std::pow(std::abs(s), power), -1.0 / power);
    return Vector3d(0.5 * size_m.cwiseProduct(Vector3d(across * r * c, across * r * s, z)));
  };
  std::array<double, 16> areas{};
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const Vector3d a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      const double area = 0.5 * ((b - a).cross(c - a).norm() + (c - a).cross(d - a).norm());
      for (const std::size_t bin : bins_of(Vector3d(0.25 * (a + b + c + d)))) areas.at(bin) += area;
    }
  }
  return areas;
}

TEST(Shapes, SuperquadricsAreSampledByArea) {
  const Vector3d size_m(24e-3, 36e-3, 60e-3);
  const auto bins_of = [&](const Vector3d& p) {
    const std::size_t octant = (p.x() > 0 ? 1U : 0U) + (p.y() > 0 ? 2U : 0U) + (p.z() > 0 ? 4U : 0U);
    const double band = 8.0 * (p.z() / size_m.z() + 0.5);
    return std::array<std::size_t, 2>{octant, 8 + static_cast<std::size_t>(std::clamp(band, 0.0, 7.0))};
  };
  for (const Exponents e : {Exponents{1.0, 1.0}, Exponents{0.3, 1.0}, Exponents{0.1, 0.1}, Exponents{2.0, 2.0}}) {
    SCOPED_TRACE(testing::Message() << e.north_south << ", " << e.east_west);
    const std::array<double, 16> areas = area_by_bins(size_m, e, bins_of);
    const double area = std::accumulate(areas.begin(), areas.begin() + 8, 0.0);
    const Index count = 6000;
    std::array<double, 16> samples{};
    const PointCloud cloud = sample_superquadric(size_m, e, count);
    for (Index i = 0; i < count; ++i) {
      for (const std::size_t bin : bins_of(cloud.points_m.col(i))) ++samples.at(bin);
    }
    double chi_squared = 0.0;
    for (std::size_t bin = 0; bin < 16; ++bin) {
      const double expected = static_cast<double>(count) * areas.at(bin) / area;
      chi_squared += (samples.at(bin) - expected) * (samples.at(bin) - expected) / expected;
    }
    // 14 degrees of freedom: random samples would give 14. Blue noise varies along the rims of the bins alone.
    EXPECT_LT(chi_squared, 4.0);
  }
}

TEST(Shapes, RoundSolidsAreSampledByArea) {
  const Index count = 8000;
  const double pi = std::numbers::pi;
  const PointCloud cylinder = sample_cylinder(12e-3, 60e-3, count);
  const double cylinder_m2 = 2.0 * pi * 12e-3 * (60e-3 + 12e-3);
  const auto on_caps = static_cast<double>((cylinder.normals.row(2).array().abs() == 1.0).count());
  // As for a box: some tenths of the samples along the edges, here 2 x 75 / 0.8 of them.
  EXPECT_NEAR(on_caps, static_cast<double>(count) * 2.0 * pi * 12e-3 * 12e-3 / cylinder_m2, 30.0);

  const PointCloud mug = sample_mug(kMug, count);
  const double inner_m = kMug.radius_m - kMug.wall_m, depth_m = kMug.height_m - kMug.wall_m;
  double bottom = 0.0, rim = 0.0, floor = 0.0, inner = 0.0, outer = 0.0, inner_half = 0.0;
  for (Index i = 0; i < count; ++i) {
    const Vector3d p = mug.points_m.col(i), n = mug.normals.col(i);
    if (n.z() == -1.0) ++bottom;
    if (n.z() == 1.0) ++(p.z() > 0.0 ? rim : floor);
    const double outwards = n.dot(Vector3d(p.x(), p.y(), 0.0).normalized());
    if (outwards < -1.0 + 1e-9 && std::abs(p.head<2>().norm() - inner_m) < 1e-12) ++inner;
    if (outwards < -1.0 + 1e-9 && std::abs(p.head<2>().norm() - inner_m) < 1e-12 && p.x() < 0.0) ++inner_half;
    if (outwards > 1.0 - 1e-9 && p.x() < 0.0) ++outer;  // the half without the handle
  }
  const double known_m2 = pi * (2.0 * kMug.radius_m * kMug.radius_m + 2.0 * inner_m * depth_m +
                                kMug.radius_m * kMug.height_m);  // the rim and the floor make one disc
  const double per_m2 = (bottom + rim + floor + inner + outer) / known_m2;
  const double R2 = kMug.radius_m * kMug.radius_m;
  EXPECT_NEAR(bottom / per_m2, pi * R2, 0.05 * pi * R2);
  EXPECT_NEAR(floor / per_m2, pi * inner_m * inner_m, 0.05 * pi * R2);
  EXPECT_NEAR(inner / per_m2, 2.0 * pi * inner_m * depth_m, 0.02 * 2.0 * pi * inner_m * depth_m);
  EXPECT_NEAR(inner_half / inner, 0.5, 0.02);
  EXPECT_NEAR(outer / per_m2, pi * kMug.radius_m * kMug.height_m, 0.02 * pi * kMug.radius_m * kMug.height_m);
}

// A cup is a cylinder less another one, whose centroid is half a wall higher.
TEST(Shapes, AMugsCentroidIsThatOfItsCylinders) {
  const Mug cup{15e-3, 34e-3, 4e-3, {}};
  const double whole = 15.0 * 15.0 * 34.0, hollow = 11.0 * 11.0 * 30.0;  // mm^3 over pi
  const Vector3d known_m(0.0, 0.0, -1e-3 * hollow * 2.0 / (whole - hollow));
  EXPECT_LE((centroid_m(cup) - known_m).norm(), 1e-17);
}

// With its handle, against the field of its solid: the mean of those of random points, one a cell, that are inside.
TEST(Shapes, AMugsCentroidIsThatOfItsSolid) {
  constexpr double kCell_m = 0.2e-3;
  // The second one's rod is so thick that the wall's curvature, which the handle begins at, moves the centroid by 0.06
  // mm.
  for (const Mug& mug : {kMug, Mug{15e-3, 40e-3, 1e-3, MugHandle{8e-3, 12e-3}}}) {
    SCOPED_TRACE(mug.height_m);
    const double out_m = mug.radius_m + mug.handle->radius_m + 0.5 * mug.handle->thickness_m;
    const Vector3d low_m(-mug.radius_m, -mug.radius_m, -0.5 * mug.height_m), high_m(out_m, -low_m.y(), -low_m.z());
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> in_cell(0.0, kCell_m);
    Vector3d sum = Vector3d::Zero();
    double inside = 0.0, cut_m2 = 0.0;
    for (double x = low_m.x(); x < high_m.x(); x += kCell_m) {
      for (double y = low_m.y(); y < high_m.y(); y += kCell_m) {
        for (double z = low_m.z(); z < high_m.z(); z += kCell_m) {
          const Vector3d p(x + in_cell(random), y + in_cell(random), z + in_cell(random));
          const double field_m = mug_field(mug, p).f_m;
          if (std::abs(field_m) < std::sqrt(3.0) * kCell_m) cut_m2 += (p - centroid_m(mug)).squaredNorm();
          if (field_m >= 0.0) continue;
          sum += p;
          ++inside;
        }
      }
    }
    // A cell within the solid errs by a part of its width, one that the surface cuts by a yes or no.
    const double deviation_m = std::sqrt(inside * kCell_m * kCell_m / 4.0 + cut_m2 / 4.0) / inside;
    EXPECT_LE(4.0 * deviation_m, 0.05e-3);
    EXPECT_LE((centroid_m(mug) - sum / inside).norm(), 4.0 * deviation_m);
    EXPECT_EQ(centroid_m(mug).y(), 0.0);
  }
}

TEST(Shapes, TheSurfaceOfTheSamplesPartsInsideFromOutside) {
  constexpr double kReach_m = 3e-3;
  for (const Solid& solid : solids()) {
    SCOPED_TRACE(solid.name);
    const PointCloud cloud = solid.sample(6000, 1);
    const ImplicitSurface surface(cloud);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    int queries = 0;
    for (int i = 0; i < 3000; ++i) {
      // Near a sample, so that most are near the surface.
      const Vector3d away = 2.0 * Vector3d(unit(random), unit(random), unit(random)) * 1e-3;
      const Vector3d x_m = cloud.points_m.col(i % cloud.points_m.cols()) + away;
      const double f_m = solid.field(x_m).f_m;
      // Edges that are rounder than the samples are dense.
      if (std::abs(f_m) < 0.3e-3) continue;
      const auto found = surface.distance(x_m, kReach_m);
      if (!found) continue;
      ++queries;
      EXPECT_EQ(found->distance_m > 0.0, f_m > 0.0) << x_m.transpose() << ": " << f_m;
    }
    EXPECT_GT(queries, 1500);
  }
}

TEST(Shapes, SameSeedSameCloud) {
  const PointCloud box = sample_box(kBox_m, 500, 7), sphere = sample_sphere(8e-3, 500, 7);
  EXPECT_EQ(box.points_m, sample_box(kBox_m, 500, 7).points_m);
  EXPECT_EQ(sphere.points_m, sample_sphere(8e-3, 500, 7).points_m);
  EXPECT_NE(box.points_m, sample_box(kBox_m, 500, 8).points_m);
  EXPECT_NE(sphere.points_m, sample_sphere(8e-3, 500, 8).points_m);
  for (const Solid& solid : solids()) {
    EXPECT_EQ(solid.sample(200, 7).points_m, solid.sample(200, 7).points_m) << solid.name;
    EXPECT_NE(solid.sample(200, 7).points_m, solid.sample(200, 8).points_m) << solid.name;
  }
}

TEST(Shapes, RefusesWhatHasNoSurface) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)sample_box({1.0, 0.0, 1.0}, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_box({1.0, nan, 1.0}, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_box({1.0, 1.0, 1.0}, 0), std::invalid_argument);
  EXPECT_THROW((void)sample_sphere(-1.0, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_sphere(nan, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_sphere(1.0, 0), std::invalid_argument);
  EXPECT_THROW((void)sample_cylinder(1.0, 0.0, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_ellipsoid({1.0, 1.0, nan}, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_superquadric({1.0, 1.0, 1.0}, {0.05, 1.0}, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_superquadric({1.0, 1.0, 1.0}, {1.0, 2.1}, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_superquadric({1.0, 1.0, 1.0}, {1.0, nan}, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_mug({1.0, 1.0, 1.0, {}}, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_mug({1.0, 1.0, 0.1, MugHandle{0.3, 0.6}}, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_mug({1.0, 1.0, 0.1, MugHandle{0.4, 0.2}}, 10), std::invalid_argument);
  EXPECT_THROW((void)sample_mug({0.3, 1.0, 0.1, MugHandle{0.25, 0.2}}, 10), std::invalid_argument);
}

}  // namespace
}  // namespace thenar::shapes_test
