// SPDX-License-Identifier: Apache-2.0
#include "collision/implicit_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "collision/cloud_repair.h"
#include "collision/shapes.h"
#include "tests/collision/distance_errors.h"

// The cases T1..T14 of the point-cloud distance use a box of 50 x 50 x 100 mm of 36 000 blue-noise points (spacing
// 0.83 mm) and h = 1.83 mm, unless said. Their bounds are requirements on the accuracy, as given.

namespace thenar::implicit_surface_test {
namespace {

using namespace distance_errors;

using Eigen::Matrix3Xd;

const ImplicitSurface& box() {
  static const ImplicitSurface kSurface(box_cloud(), 1.83 * kMm);
  return kSurface;
}

TEST(ImplicitSurface, T1FlatFace) {
  for (const double gap_mm : {-3.0, -1.0, 0.0, 0.3, 1.0}) {
    SCOPED_TRACE(gap_mm);
    const Errors errors = measure(box(), over_face(gap_mm));
    EXPECT_EQ(errors.undefined, 0);
    EXPECT_LT(errors.max_mm, 0.01);
  }
}

TEST(ImplicitSurface, T2SphereIsExact) {
  // The mean of the samples lies h^2/12R under the surface, 21 um. The sphere through them does not. From farther off
  // two projections end beside the foot of x, by the share gap/R of a sample's cell, which reaches a spacing and a
  // quarter at most.
  const double radius_mm = 8.0, h_mm = 1.43, spacing_mm = 0.65;
  const ImplicitSurface sphere(sample_sphere(radius_mm * kMm, 1900), h_mm * kMm);
  for (const double gap_mm : {-3.0, -1.0, 0.0, 0.3, 1.0, 3.0}) {
    SCOPED_TRACE(gap_mm);
    const double aside_mm = gap_mm / radius_mm * 1.25 * spacing_mm;
    Random random(2);
    for (int i = 0; i < kQueries; ++i) {
      const Vector3d n = random.direction();
      const auto to = sphere.distance((radius_mm + gap_mm) * kMm * n, kReach_m);
      ASSERT_TRUE(to);
      ASSERT_NEAR(to->distance_m, gap_mm * kMm, 0.1e-6 + aside_mm * aside_mm / (2.0 * radius_mm) * kMm);
      ASSERT_LT((to->normal - n).norm(), 3e-4 + std::abs(aside_mm) / radius_mm);
    }
  }
}

// Two radii of curvature are seen as one, their mean: exact as far as samples are as wide apart along as across.
TEST(ImplicitSurface, CylinderIsNearlyAsExact) {
  const double radius_mm = 20.0;
  const ImplicitSurface surface(sample_cylinder(radius_mm * kMm, 60.0 * kMm, 20000));
  const double h_mm = surface.support_m() / kMm, plane_mm = h_mm * h_mm / (24.0 * radius_mm);
  const Errors errors = measure(
      surface,
      [&](Random& random) -> Vector3d {
        const double angle = random.between(0.0, 2.0 * std::numbers::pi),
                     r = (radius_mm + random.between(-1.0, 0.5)) * kMm;
        return {r * std::cos(angle), r * std::sin(angle), random.between(-20.0, 20.0) * kMm};
      },
      [&](const Vector3d& x_m) { return x_m.head<2>().norm() - radius_mm * kMm; });
  EXPECT_EQ(errors.undefined, 0);
  EXPECT_LT(errors.mean_mm, 0.1 * plane_mm);
  EXPECT_LT(errors.max_mm, plane_mm);
}

TEST(ImplicitSurface, T3FaceNearAnEdge) {
  for (const double from_edge_mm : {0.1, 0.4, 0.8, 1.2, 1.8}) {
    SCOPED_TRACE(from_edge_mm);
    const Errors errors = measure(box(), [=](Random& random) -> Vector3d {
      return {kHalf_m.x() - from_edge_mm * kMm, kHalf_m.y(), random.between(-40, 40) * kMm};
    });
    EXPECT_EQ(errors.undefined, 0);
    EXPECT_LT(errors.mean_mm, 0.05);
    EXPECT_LT(errors.max_mm, 0.1);
  }
}

TEST(ImplicitSurface, T4RingAroundAnEdge) {
  for (const double radius_mm : {0.3, 0.8, 1.5}) {
    SCOPED_TRACE(radius_mm);
    const Errors errors = measure(box(), around_edge(radius_mm));
    EXPECT_EQ(errors.undefined, 0);
    EXPECT_EQ(errors.wrong_sign, 0);
    EXPECT_LT(errors.mean_mm, 0.05);
    // Outside the edge the distance is that to the farther plane: at worst, on the bisector, r cos 45 degrees for r.
    EXPECT_LT(errors.max_mm, (1.0 - std::sqrt(0.5)) * radius_mm + 0.01);
  }
}

TEST(ImplicitSurface, T5CubeCorner) {
  const Errors errors = measure(box(), around_corner(0.8));
  EXPECT_EQ(errors.undefined, 0);
  EXPECT_EQ(errors.wrong_sign, 0);
  EXPECT_LT(errors.mean_mm, 0.2);
}

TEST(ImplicitSurface, T6T7PlatesHaveTheRightSign) {
  for (const double thickness_mm : {4.0, 2.0, 1.0, 0.5}) {
    SCOPED_TRACE(thickness_mm);
    const Vector3d size_m(50 * kMm, thickness_mm * kMm, 100 * kMm), half_m = 0.5 * size_m;
    const ImplicitSurface plate(sample_box(size_m, 20600));
    const Errors errors = measure(
        plate,
        [&](Random& random) -> Vector3d {
          return {random.between(-20, 20) * kMm, half_m.y() + random.between(-0.3, 0.3) * kMm,
                  random.between(-40, 40) * kMm};
        },
        [&](const Vector3d& x_m) { return box_distance_m(x_m, half_m); });
    EXPECT_EQ(errors.undefined, 0);
    EXPECT_EQ(errors.wrong_sign, 0);
    EXPECT_LT(errors.max_mm, 0.01);  // flat, as T1
  }
}

// From beyond the middle of a curved wall its back is nearer; the face that a sample on its outside belongs to is still
// as far as it is, but for the samples' own sag of h^2 / 12 R.
TEST(ImplicitSurface, FaceDistanceIsThatOfTheSampleOwnFace) {
  constexpr double kOuter_m = 27.5e-3;
  const ImplicitSurface mug(sample_mug({.radius_m = kOuter_m, .height_m = 70e-3, .wall_m = 3e-3, .handle = {}}, 36000));
  for (int i = 0; i < 200; ++i) {
    const double depth_m = 0.1e-3 + 2.8e-3 * i / 200.0, angle = 0.7 * i;
    const Vector3d out(std::cos(angle), std::sin(angle), 0.0);
    const Vector3d x_m = (kOuter_m - depth_m) * out + 0.1e-3 * (i - 100) * Vector3d::UnitZ();
    const Eigen::Index sample = mug.nearest(x_m + depth_m * out, 1e-3).sample;
    ASSERT_GE(sample, 0);
    const SurfaceDistance face = mug.face_distance(x_m, sample);
    EXPECT_NEAR(face.distance_m, -depth_m, 20e-6);
    EXPECT_GT(face.normal.dot(out), 0.999);
  }
}

TEST(ImplicitSurface, T7RimsOfThinPlatesHaveTheRightSign) {
  // All around the rim and the corners, as far as the search goes. A rim of 0.5 mm holds a single row of samples.
  for (const double thickness_mm : {1.0, 0.5}) {
    SCOPED_TRACE(thickness_mm);
    const Vector3d half_m = 0.5 * Vector3d(50 * kMm, thickness_mm * kMm, 100 * kMm);
    const PointCloud cloud = sample_box(2.0 * half_m, 20600);
    const ImplicitSurface plate(cloud, covering_support_m(cloud));
    const auto truth_m = [&](const Vector3d& x_m) { return box_distance_m(x_m, half_m); };
    const Query along_x = [&](Random& random) -> Vector3d {
      return {random.sign() * (half_m.x() + random.between(-2, 2) * kMm), random.between(-2, 2) * kMm,
              random.between(-48, 48) * kMm};
    };
    const Query at_corners = [&](Random& random) -> Vector3d {
      return {random.sign() * (half_m.x() + random.between(-2, 2) * kMm), random.between(-2, 2) * kMm,
              random.sign() * (half_m.z() + random.between(-2, 2) * kMm)};
    };
    for (const Query& query : {along_x, at_corners}) {
      const Errors errors = measure(plate, query, truth_m);
      EXPECT_EQ(errors.undefined, 0);
      EXPECT_EQ(errors.wrong_sign, 0);
    }
  }
}

TEST(ImplicitSurface, NeedlesHaveTheRightSign) {
  // 0.5 mm in diameter, 40 mm long, samples 0.2 mm apart: eight around.
  const double radius_m = 0.25 * kMm;
  PointCloud needle{Matrix3Xd(3, 1602), Matrix3Xd(3, 1602)};
  for (Index i = 0; i < 1600; ++i) {
    const Index ring = i / 8;
    const double turn = (static_cast<double>(i % 8) + 0.5 * static_cast<double>(ring % 2)) * std::numbers::pi / 4.0;
    needle.normals.col(i) = Vector3d(std::cos(turn), std::sin(turn), 0.0);
    needle.points_m.col(i) = radius_m * needle.normals.col(i);
    needle.points_m(2, i) = (static_cast<double>(ring) - 99.5) * 0.2 * kMm;
  }
  needle.points_m.rightCols<2>() << 0, 0, 0, 0, -20 * kMm, 20 * kMm;
  needle.normals.rightCols<2>() << 0, 0, 0, 0, -1, 1;
  const Errors errors = measure(
      ImplicitSurface(needle, 0.44 * kMm),
      [&](Random& random) -> Vector3d {
        const double turn = random.between(0.0, 2.0 * std::numbers::pi), r_m = random.between(0, 2) * kMm;
        return {r_m * std::cos(turn), r_m * std::sin(turn), random.between(-22, 22) * kMm};
      },
      [&](const Vector3d& x_m) {
        const double side_m = x_m.head<2>().norm() - radius_m, end_m = std::abs(x_m.z()) - 20 * kMm;
        return side_m > 0.0 && end_m > 0.0 ? std::hypot(side_m, end_m) : std::max(side_m, end_m);
      });
  EXPECT_EQ(errors.undefined, 0);
  EXPECT_EQ(errors.wrong_sign, 0);
}

TEST(ImplicitSurface, GapIsContinuousAcrossAnEdge) {
  // Along lines across the edge between x+ and y+ at heights above and below the face, steps of 2 um. The signed
  // distance changes by no more than the step; both planes are exact, so no more than rounding is allowed for.
  const double step_m = 2e-6;
  for (const double height_mm : {1.0, 0.3, 0.0, -0.3, -1.0, -2.0, -3.0}) {
    Random random(4);
    for (int line = 0; line < 4; ++line) {
      const double z_m = random.between(-40, 40) * kMm;
      std::optional<double> last_m;
      for (int k = 0; k < 2500; ++k) {
        const Vector3d x_m(kHalf_m.x() - 4 * kMm + step_m * k, kHalf_m.y() + height_mm * kMm, z_m);
        const std::optional<SurfaceDistance> to = box().distance(x_m, 6 * kMm);
        ASSERT_TRUE(to.has_value());
        if (last_m) {
          ASSERT_LE(std::abs(to->distance_m - *last_m), step_m + 1e-9)
              << height_mm << " mm high, at x = " << x_m.x() / kMm << " mm, z = " << z_m / kMm << " mm";
        }
        last_m = to->distance_m;
      }
    }
  }
}

TEST(ImplicitSurface, T12HolesAreBridged) {
  // By the plane at the rim, so exactly on a face. On a sphere it lies up to r^2/2R off in the middle of the hole,
  // twice that where the plane comes from the far rim. Wider holes than the reach are refused: see find_holes().
  const auto disc = [](Random& random, double radius_mm) -> Eigen::Vector2d {
    const double r_m = radius_mm * kMm * std::sqrt(random.between(0.0, 1.0));
    const double angle = random.between(0.0, 2.0 * std::numbers::pi);
    return {r_m * std::cos(angle), r_m * std::sin(angle)};
  };
  const double R_mm = 25.0;
  const PointCloud sphere = sample_sphere(R_mm * kMm, 11400);  // spacing 0.83 mm
  for (const double radius_mm : {1.0, 2.0, 4.0}) {
    SCOPED_TRACE(radius_mm);
    const auto torn = [&](const PointCloud& cloud, const Vector3d& centre_m) {
      return subset(cloud, [&](Index i) { return (cloud.points_m.col(i) - centre_m).norm() > radius_mm * kMm; });
    };
    const double reach_m = 5 * kMm;
    const Errors on_face = measure(
        ImplicitSurface(torn(box_cloud(), {0.0, kHalf_m.y(), 0.0}), 1.83 * kMm),
        [&](Random& random) -> Vector3d {
          const Eigen::Vector2d at_m = disc(random, radius_mm);
          return {at_m.x(), kHalf_m.y() + 0.3 * kMm, at_m.y()};
        },
        reach_m);
    EXPECT_EQ(on_face.undefined, 0);
    EXPECT_LT(on_face.max_mm, 0.01);  // flat, as T1
    const Errors on_sphere = measure(
        ImplicitSurface(torn(sphere, R_mm * kMm * Vector3d::UnitZ()), 1.83 * kMm),
        [&](Random& random) -> Vector3d {
          const Eigen::Vector2d at_m = disc(random, radius_mm);
          return (R_mm + 0.3) * kMm * Vector3d(at_m.x(), at_m.y(), R_mm * kMm).normalized();
        },
        [&](const Vector3d& x_m) { return x_m.norm() - R_mm * kMm; }, reach_m);
    EXPECT_EQ(on_sphere.undefined, 0);
    EXPECT_LT(on_sphere.max_mm, 0.03 + radius_mm * radius_mm / R_mm);
  }
}

TEST(ImplicitSurface, T13ThinnedCloudsGetAWiderSupport) {
  for (const double kept : {0.5, 0.25, 0.1}) {
    SCOPED_TRACE(kept);
    Random random(13);
    const PointCloud thin = subset(box_cloud(), [&](Index) { return random.between(0.0, 1.0) < kept; });
    const ImplicitSurface surface(thin);
    // Random thinning tears holes of some spacings, 2.6 mm where a tenth is kept: the reach must span them.
    const Errors errors = measure(surface, over_face(0.3), 2.0 * surface.support_m());
    EXPECT_EQ(errors.undefined, 0);
    EXPECT_LT(errors.max_mm, 0.01);  // flat, as T1
  }
}

TEST(ImplicitSurface, T13UnevenDensityGetsTheSupportOfItsSparsestRegion) {
  Random random(13);
  const PointCloud uneven =
      subset(box_cloud(), [&](Index i) { return box_cloud().points_m(2, i) < 0.0 || random.between(0.0, 1.0) < 0.25; });
  const double support_m = covering_support_m(uneven);
  // A quarter of the samples: twice the spacing, found to 10 % as chance has it.
  EXPECT_NEAR(support_m, 2.0 * 1.83 * kMm, 0.2 * 1.83 * kMm);
  const ImplicitSurface surface(uneven, support_m);
  for (const Query& query : {over_face(0.3), over_face(-1.0), around_edge(0.8), around_corner(0.8)}) {
    const Errors errors = measure(surface, query);
    EXPECT_EQ(errors.undefined, 0);
    EXPECT_EQ(errors.wrong_sign, 0);
  }
}

TEST(ImplicitSurface, SupportIsTwoPointTwoSpacings) {
  // Spacing: the side of the square that one sample stands for. The estimate from eight neighbours is exact to some
  // percent, and to 10 percent for random samples; the accuracy above changes little with h.
  const double box_m = std::sqrt(2.0 * (50.0 * 50.0 + 2.0 * 50.0 * 100.0) / 36000.0) * kMm;
  EXPECT_NEAR(ImplicitSurface(box_cloud()).support_m() / (2.2 * box_m), 1.0, 0.05);
  const double sphere_m = std::sqrt(4.0 * std::numbers::pi * 64.0 / 2400.0) * kMm;
  EXPECT_NEAR(ImplicitSurface(sample_sphere(8 * kMm, 2400)).support_m() / (2.2 * sphere_m), 1.0, 0.05);
  Random random(2);
  const PointCloud thin = subset(box_cloud(), [&](Index) { return random.between(0.0, 1.0) < 0.1; });
  const double thin_m = box_m * std::sqrt(36000.0 / static_cast<double>(thin.points_m.cols()));
  EXPECT_NEAR(ImplicitSurface(thin).support_m() / (2.2 * thin_m), 1.0, 0.1);
}

TEST(ImplicitSurface, ReachIsMeasuredToTheNearestSample) {
  // Found just within the distance to the nearest sample and not just short of it: the search is exact.
  for (unsigned seed = 1; seed <= 1000; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Vector3d x_m = random.in_cube(60 * kMm);
    if (seed % 3 == 0) x_m = box().cloud().points_m.col(36 * seed - 36) + random.in_cube(2 * kMm);
    const double nearest_m = (box().cloud().points_m.colwise() - x_m).colwise().norm().minCoeff();
    EXPECT_TRUE(box().distance(x_m, nearest_m * (1.0 + 1e-12)).has_value());
    EXPECT_FALSE(box().distance(x_m, nearest_m * (1.0 - 1e-12)).has_value());
  }
}

TEST(ImplicitSurface, FollowsItsDefinition) {
  // The header's formulas summed over all samples, on a surface without edges; only the order of the sums differs.
  const PointCloud cloud = sample_ellipsoid({16 * kMm, 20 * kMm, 24 * kMm}, 2400);
  const double h_m = 1.43 * kMm;
  const ImplicitSurface surface(cloud, h_m);
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Vector3d x_m =
        Vector3d(random.between(0.9, 1.2) * kMm * random.direction().array() * Eigen::Array3d(8, 10, 12));
    Index nearest = 0;
    (cloud.points_m.colwise() - x_m).colwise().squaredNorm().minCoeff(&nearest);
    Vector3d c_m = cloud.points_m.col(nearest), n = cloud.normals.col(nearest);
    double f_m = 0.0;
    for (int projection = 0; projection < 2; ++projection) {
      const Eigen::RowVectorXd d_m = (cloud.points_m.colwise() - c_m).colwise().norm();
      const Eigen::RowVectorXd th = (1.0 - (d_m.array() / h_m).square()).max(0.0).pow(4.0) *
                                    (2.0 * (n.transpose() * cloud.normals).array() - 1.0).max(0.0).pow(4.0);
      const auto mean = [&](const auto& columns) { return Vector3d((columns * th.transpose()) / th.sum()); };
      const Vector3d a_m = mean(cloud.points_m), m = mean(cloud.normals), m_1 = m.normalized();
      const Matrix3Xd from_a_m = cloud.points_m.colwise() - a_m, turned = cloud.normals.colwise() - m;
      const double spread_m2 = th.dot(from_a_m.colwise().squaredNorm()) / th.sum();
      const double bend = th.dot((from_a_m.array() * turned.array()).colwise().sum().matrix()) / th.sum() / spread_m2;
      const Vector3d aside_m = (a_m - c_m) - m_1.dot(a_m - c_m) * m_1;
      const Vector3d foot_m = a_m - aside_m + 0.5 * bend * (spread_m2 - aside_m.squaredNorm()) * m_1;
      n = (m_1 - bend * aside_m).normalized();
      f_m = n.dot(x_m - foot_m);
      c_m = x_m - f_m * n;
    }
    const std::optional<SurfaceDistance> to = surface.distance(x_m, kReach_m);
    ASSERT_TRUE(to.has_value());
    EXPECT_NEAR(to->distance_m, f_m, 1e-14);
    EXPECT_LT((to->point_m - c_m).norm(), 1e-14);
    EXPECT_LT((to->normal - n).norm(), 1e-12);
  }
}

TEST(ImplicitSurface, ConcaveEdgesAreUnionsOfHalfSpaces) {
  // A box turned inside out is a room: its walls meet in concave edges. The true distance inside the room is that to
  // the nearest wall.
  PointCloud room = sample_box({20 * kMm, 20 * kMm, 20 * kMm}, 6000);
  room.normals *= -1.0;
  const ImplicitSurface surface(room);
  const Errors errors = measure(
      surface,
      [](Random& random) -> Vector3d {
        return {random.between(8, 9.9) * kMm, random.between(8, 9.9) * kMm, random.between(-8, 8) * kMm};
      },
      [](const Vector3d& x_m) { return (10 * kMm - x_m.cwiseAbs().array()).minCoeff(); });
  EXPECT_EQ(errors.undefined, 0);
  EXPECT_EQ(errors.wrong_sign, 0);
  // The planes are exact. Off by more only if the nearest wall has no sample in sight of the nearest sample: both walls
  // are then equally far to within a spacing's slant, s^2/2d = 0.15 mm.
  EXPECT_LT(errors.max_mm, 0.15);
  EXPECT_LT(errors.mean_mm, 0.01);
}

TEST(ImplicitSurface, DegenerateCloudsGiveNoNan) {
  Random random(17);
  const auto cloud_of = [&](Index count, const std::function<Vector3d(Index)>& point) {
    PointCloud cloud{Matrix3Xd(3, count), Matrix3Xd(3, count)};
    for (Index i = 0; i < count; ++i) {
      cloud.points_m.col(i) = point(i);
      cloud.normals.col(i) = random.direction();
    }
    return cloud;
  };
  const std::vector<PointCloud> clouds = {
      cloud_of(1, [](Index) { return Vector3d::Zero(); }),
      cloud_of(2, [](Index i) -> Vector3d { return static_cast<double>(i) * kMm * Vector3d::UnitX(); }),
      cloud_of(30, [](Index) { return Vector3d::Zero(); }),
      cloud_of(30, [](Index i) -> Vector3d { return 0.1 * kMm * static_cast<double>(i) * Vector3d::UnitX(); }),
      cloud_of(300, [&](Index) { return random.in_cube(1.5 * kMm); }),
      sample_sphere(1 * kMm, 12)};
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    const ImplicitSurface surface(clouds[k], 1 * kMm);
    for (int i = 0; i < 2000; ++i) {
      SCOPED_TRACE(testing::Message() << "cloud " << k << ", query " << i);
      // Among them samples, the middle of a sphere, and points far off.
      Vector3d x_m = random.in_cube(std::pow(10.0, random.between(-6.0, 0.0)));
      if (i % 4 == 0) x_m = clouds[k].points_m.col(i % clouds[k].points_m.cols());
      if (i == 1) x_m.setZero();
      const std::optional<SurfaceDistance> to = surface.distance(x_m, i % 3 == 0 ? 10.0 : kReach_m);
      if (!to) continue;
      ASSERT_TRUE(std::isfinite(to->distance_m) && to->point_m.allFinite());
      ASSERT_NEAR(to->normal.norm(), 1.0, 1e-12);
      // The projection is where the distance says.
      ASSERT_LT((to->point_m + to->distance_m * to->normal - x_m).norm(), 1e-15 + 1e-12 * x_m.norm());
    }
  }
}

TEST(ImplicitSurface, IsStoredInTheOrderOfItsBlocks) {
  const PointCloud cloud = sample_sphere(8 * kMm, 997);
  const ImplicitSurface surface(cloud, 1 * kMm);
  const std::vector<Index> order = SampleBlocks::order(surface.cloud().points_m);
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], static_cast<Index>(i));
  // The same samples in another order, and all of them within the bounds.
  EXPECT_NEAR((cloud.points_m.rowwise().sum() - surface.cloud().points_m.rowwise().sum()).norm(), 0.0, 1e-12);
  EXPECT_EQ(surface.bounds().min(), cloud.points_m.rowwise().minCoeff());
  EXPECT_EQ(surface.bounds().max(), cloud.points_m.rowwise().maxCoeff());
}

TEST(ImplicitSurface, RefusesWhatHasNoSpacing) {
  const PointCloud one{Vector3d::Zero(), Vector3d::UnitX()};
  const PointCloud same_place{Matrix3Xd::Zero(3, 20), Vector3d::UnitX().replicate(1, 20)};
  EXPECT_THROW(ImplicitSurface{one}, std::invalid_argument);
  EXPECT_THROW(ImplicitSurface{same_place}, std::invalid_argument);
  EXPECT_THROW(ImplicitSurface(same_place, 0.0), std::invalid_argument);
  EXPECT_THROW(ImplicitSurface(same_place, std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_THROW(ImplicitSurface(PointCloud{}), std::invalid_argument);
}

}  // namespace
}  // namespace thenar::implicit_surface_test
