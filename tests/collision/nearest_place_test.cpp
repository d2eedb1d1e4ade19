// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <variant>

#include "tests/collision/exact_shapes.h"

namespace thenar::exact_shapes {
namespace {

const double kInner_m = kMug.radius_m - kMug.wall_m, kTop_m = 0.5 * kMug.height_m, kFloor_m = kMug.wall_m - kTop_m;

/// Whether x is in the solid, by the formula of the whole.
bool contains(const ExactShape& shape, const Vector3d& x) {
  const double rho = x.head<2>().norm();
  if (const auto* box = std::get_if<BoxShape>(&shape)) return ((0.5 * box->size_m - x.cwiseAbs()).array() > 0.0).all();
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape))
    return rho < cylinder->radius_m && std::abs(x[2]) < 0.5 * cylinder->length_m;
  const auto* mug = std::get_if<Mug>(&shape);
  if (mug == nullptr) return off_face_m(shape, 0, x) < 0.0;
  const double half_m = 0.5 * mug->height_m;
  const bool hollow = rho < mug->radius_m - mug->wall_m && x[2] > mug->wall_m - half_m;
  if (rho < mug->radius_m) return std::abs(x[2]) < half_m && !hollow;
  return mug->handle && off_face_m(shape, 5, x) < 0.0;
}

/// The seam of a mug's handle, inside of which distances are bounds alone.
bool is_inside_near_seam(const ExactShape& shape, const Vector3d& x) {
  const auto* mug = std::get_if<Mug>(&shape);
  return mug != nullptr && mug->handle && contains(shape, x) && x.head<2>().norm() > mug->radius_m - mug->wall_m &&
         off_face_m(shape, 5, x) < 1.5 * mug->wall_m;
}

// No sample of the surface is nearer than the nearest place, which is on the surface: it is the nearest. Its sign is
// that of the solid, and with samples h apart none is missed by more than that.
TEST(NearestPlace, NoSampleIsNearerThanTheNearestPlace) {
  for (const Case& one : cases()) {
    SCOPED_TRACE(one.name);
    const PointCloud dense = sample(one.shape, 10'000);
    Random random(5);
    for (int trial = 0; trial < 1000; ++trial) {
      const Vector3d x = random.in_cube(60e-3);
      if (is_inside_near_seam(one.shape, x)) continue;
      const SurfaceForm at = nearest_place(one.shape, x);
      const double least_m = std::sqrt((dense.points_m.colwise() - x).colwise().squaredNorm().minCoeff());
      ASSERT_LE(std::abs(at.distance_m), least_m + (is_superquadric(one) ? 1e-9 : 1e-12)) << "x " << x.transpose();
      ASSERT_GE(std::abs(at.distance_m), least_m - 2e-3) << "x " << x.transpose() << " seed 5";
      ASSERT_EQ(at.distance_m < 0.0, contains(one.shape, x)) << "x " << x.transpose();
      ASSERT_LT((x - at.point_m - at.distance_m * at.normal).norm(), 1e-9 * std::max(1e-3, std::abs(at.distance_m)));
      ASSERT_LT(std::abs(nearest_place(one.shape, at.point_m).distance_m), is_superquadric(one) ? 1e-9 : 1e-15);
    }
  }
}

/// How far a superquadric reaches along n: the dual norms, with 1/p + 1/q = 1.
double support_m(const SuperquadricShape& shape, const Vector3d& n) {
  const Vector3d a = (0.5 * shape.size_m).cwiseProduct(n).cwiseAbs();
  const auto dual = [](double u, double v, double p) {
    const double most = std::max(u, v), q = p / (p - 1.0);
    return p == 1.0 || most == 0.0 ? most : most * std::pow(std::pow(u / most, q) + std::pow(v / most, q), 1.0 / q);
  };
  return dual(dual(a[0], a[1], 2.0 / shape.exponents.east_west), a[2], 2.0 / shape.exponents.north_south);
}

// A convex body is below the plane across n through its support: n.x - support is a lower bound of the distance, and
// the foot an upper one. So they prove the distance, of superquadrics of all exponents, up to ten times as long as
// thick. Nearly sharp edges and poles, of exponents between 1.9 and 2, hold Newton's method up now and then.
TEST(NearestPlace, PlanesProveTheDistancesOfSuperquadrics) {
  Random random(8);
  for (int trial = 0; trial < 20'000; ++trial) {
    const auto exponent = [&] { return trial % 5 == 0 ? random.between(1.9, 2.0) : random.between(0.1, 2.0); };
    const SuperquadricShape shape{
        {random.between(10e-3, 100e-3), random.between(10e-3, 100e-3), random.between(10e-3, 100e-3)},
        {exponent(), exponent()}};
    const Vector3d x = random.in_cube(trial % 2 == 0 ? 80e-3 : 1.0);
    const SurfaceForm at = nearest_place(shape, x);
    if (at.distance_m < 1e-3) continue;
    const Vector3d n = (x - at.point_m).normalized();
    const double gap_m = support_m(shape, n) - n.dot(at.point_m);
    const bool is_nearly_sharp = std::max(shape.exponents.north_south, shape.exponents.east_west) > 1.9;
    ASSERT_LT(gap_m, is_nearly_sharp ? 5e-6 : 1e-9)
        << "seed 8, trial " << trial << ", exponents " << shape.exponents.north_south << " "
        << shape.exponents.east_west << ", size " << shape.size_m.transpose() << ", x " << x.transpose();
    ASSERT_GT(gap_m, -1e-14);
  }
}

// From 0.1 mm to 60 mm outside: the normal is the gradient of the distance, and a start anywhere changes nothing.
TEST(NearestPlace, NormalsAreTheGradientOfTheDistance) {
  constexpr double kStep_m = 1e-6;
  for (const Case& one : cases()) {
    SCOPED_TRACE(one.name);
    Random random(6);
    for (int trial = 0; trial < 1000; ++trial) {
      const Vector3d x = random.in_cube(60e-3);
      const SurfaceForm at = nearest_place(one.shape, x);
      if (at.distance_m < 1e-4) continue;
      Vector3d gradient, sides;
      for (int k = 0; k < 3; ++k) {
        const double ahead_m = nearest_place(one.shape, x + kStep_m * Vector3d::Unit(k)).distance_m;
        const double behind_m = nearest_place(one.shape, x - kStep_m * Vector3d::Unit(k)).distance_m;
        gradient[k] = (ahead_m - behind_m) / (2.0 * kStep_m);
        sides[k] = (ahead_m - 2.0 * at.distance_m + behind_m) / kStep_m;
      }
      // In a mug two walls may be as near: there the distance has a ridge.
      if (sides.minCoeff() < -1e-2 && std::holds_alternative<Mug>(one.shape)) continue;
      // The second derivative is at most 1 / distance: over the step its change is below (1e-6 / 1e-4)^2.
      ASSERT_LT((gradient - at.normal).norm(), 1e-3) << "x " << x.transpose() << " seed 6";
      const SurfaceForm other = nearest_place(one.shape, x, random.in_cube(40e-3));
      ASSERT_NEAR(other.distance_m, at.distance_m, is_superquadric(one) ? 1e-9 : 1e-15) << "x " << x.transpose();
    }
  }
}

// A distance never changes by more than the way, also where the nearest face changes.
TEST(NearestPlace, DistancesAreContinuous) {
  for (const Case& one : cases()) {
    SCOPED_TRACE(one.name);
    Random random(7);
    for (int line = 0; line < 20; ++line) {
      const Vector3d from = random.in_cube(60e-3), to = random.in_cube(60e-3);
      double last_m = nearest_place(one.shape, from).distance_m;
      for (int step = 1; step <= 200; ++step) {
        const double now_m = nearest_place(one.shape, from + step / 200.0 * (to - from)).distance_m;
        ASSERT_LE(std::abs(now_m - last_m), (to - from).norm() / 200.0 + 2e-9) << "seed 7, line " << line;
        last_m = now_m;
      }
    }
  }
}

TEST(NearestPlace, EdgesAndCornersAreSharp) {
  const BoxShape box{{20e-3, 30e-3, 40e-3}};
  const SurfaceForm edge = nearest_place(box, {13e-3, 19e-3, 5e-3}),
                    corner = nearest_place(box, {-11e-3, 16e-3, 21e-3});
  EXPECT_NEAR(edge.distance_m, 5e-3, 1e-17);
  EXPECT_LT((edge.normal - Vector3d(0.6, 0.8, 0.0)).norm(), 1e-14);
  EXPECT_NEAR(std::abs(edge.t1.dot(Vector3d(-0.8, 0.6, 0.0))), 1.0, 1e-14);
  EXPECT_EQ(edge.k1_per_m, kSharpest_per_m);
  EXPECT_EQ(edge.k2_per_m, 0.0);
  EXPECT_LT((corner.point_m - Vector3d(-10e-3, 15e-3, 20e-3)).norm(), 1e-17);
  EXPECT_EQ(corner.k2_per_m, kSharpest_per_m);

  // A rim of radius R under a normal that leans by 60 degrees from the radius: along it the curvature is cos(60) / R.
  const double R = 20e-3, s = std::sqrt(0.75);
  const SurfaceForm rim = nearest_place(CylinderShape{R, 70e-3}, {0.0, R + 1e-3, -35e-3 - 2e-3 * s});
  EXPECT_NEAR(rim.distance_m, 2e-3, 1e-15);
  EXPECT_EQ(rim.k1_per_m, kSharpest_per_m);
  EXPECT_NEAR(rim.k2_per_m, 0.5 / R, 1e-10);
  // In the wall below a mug's floor the nearest place may be the circle where floor and wall meet, which is hollow.
  const SurfaceForm root = nearest_place(kMug, {kInner_m + 1e-3, 0.0, kFloor_m - 1e-3});
  EXPECT_NEAR(root.distance_m, -std::sqrt(2.0) * 1e-3, 1e-15);
  EXPECT_EQ(root.k1_per_m, -kSharpest_per_m);
  EXPECT_LT((root.normal - Vector3d(-1.0, 0.0, 1.0).normalized()).norm(), 1e-12);
  // Above the rim.
  EXPECT_NEAR(nearest_place(kMug, {0.0, kMug.radius_m - 1e-3, kTop_m + 3e-3}).distance_m, 3e-3, 1e-15);
  // An octahedron has edges and vertices.
  const SuperquadricShape octahedron{{20e-3, 20e-3, 20e-3}, {2.0, 2.0}};
  const SurfaceForm vertex = nearest_place(octahedron, {1e-3, -0.5e-3, 13e-3});
  EXPECT_LT((vertex.point_m - Vector3d(0.0, 0.0, 10e-3)).norm(), 1e-10);
  EXPECT_EQ(vertex.k1_per_m, kSharpest_per_m);
}

}  // namespace
}  // namespace thenar::exact_shapes
