// SPDX-License-Identifier: Apache-2.0
#include "collision/solids/exact_shape.h"

#include <gtest/gtest.h>

#include <numbers>
#include <variant>
#include <vector>

#include "tests/collision/exact_shapes.h"
#include "tests/support/allocation_counter.h"

namespace thenar::exact_shapes {
namespace {

/// Samples of a case at least a millimetre from an edge, with their faces.
void for_samples(const Case& one, Index stride, const auto& use) {
  SCOPED_TRACE(one.name);
  for (Index i = 0; i < one.cloud.points_m.cols(); i += stride) {
    const Vector3d s = one.cloud.points_m.col(i), n = one.cloud.normals.col(i);
    const int face = face_at(one.shape, s, n, 1e-3);
    if (face >= 0) use(s, n, face);
    if (testing::Test::HasFailure()) return;
  }
}

/// How far inside a place the same face has no nearer one, by half of the way to the centre of curvature; and of
/// creases, how far it is to them.
double depth_m(const Case& one, const Vector3d& s, const SurfaceForm& at) {
  double least_m = 4e-3;
  if (at.k1_per_m > 0.0) least_m = std::min(least_m, 0.5 / at.k1_per_m);
  if (has_creases(one)) least_m = std::min(least_m, 0.2 * s.cwiseAbs().minCoeff());
  return least_m;
}

// Samples are on their faces, to rounding, and so is what a point over or under them has for a foot: it is the sample,
// and the distance is what they were moved by. The start is 20 um off.
TEST(ExactShape, FeetOfMovedSamplesAreTheSamples) {
  Random random(1);
  for (const Case& one : cases()) {
    for_samples(one, 1, [&](const Vector3d& s, const Vector3d& n, int face) {
      const SurfaceForm on = foot_on_face(one.shape, face, s, s);
      ASSERT_LT((on.point_m - s).norm(), 1e-15);
      ASSERT_LT((on.normal - n).norm(), has_creases(one) ? 1e-6 : 1e-9);
      const double reach_m = on.k1_per_m < 0.0 || on.k2_per_m < 0.0 ? 10e-3 : 50e-3;  // A hollow has a middle.
      const double d = random.between(-depth_m(one, s, on), reach_m);
      const SurfaceForm at = foot_on_face(one.shape, face, s + d * n, s + random.in_cube(20e-6));
      // Rounding of the generator's normals, over 50 mm.
      ASSERT_NEAR(at.distance_m, d, 1e-15) << "s " << s.transpose() << " seed 1";
      ASSERT_LT((at.point_m - s).norm(), is_superquadric(one) ? 1e-12 : 1e-14) << "s " << s.transpose() << " d " << d;
    });
  }
}

// Where a foot is not known beforehand: it is on the surface by the textbook's formula, below x, and its axes are a
// frame.
TEST(ExactShape, FeetAreOnTheSurfaceBelowThePoint) {
  Random random(2);
  for (const Case& one : cases()) {
    for_samples(one, 3, [&](const Vector3d& s, const Vector3d& n, int face) {
      const SurfaceForm on = foot_on_face(one.shape, face, s, s);
      const double d = random.between(-depth_m(one, s, on), 8e-3);
      const Vector3d x = s + d * n + random.in_cube(0.2 * std::abs(d));
      const SurfaceForm at = foot_on_face(one.shape, face, x, s);
      ASSERT_LT(std::abs(off_face_m(one.shape, face, at.point_m)), 1e-15) << "seed 2";
      // 1e-9 of the distance: 1e-13 m at a tenth of a millimetre.
      const double beside_m = (x - at.point_m - at.distance_m * at.normal).norm();
      ASSERT_LT(beside_m, 1e-9 * std::max(1e-4, std::abs(d))) << "x " << x.transpose() << " d " << d;
      ASSERT_NEAR(at.normal.norm(), 1.0, 1e-14);
      ASSERT_NEAR(at.t1.norm(), 1.0, 1e-14);
      ASSERT_NEAR(at.normal.dot(at.t1), 0.0, 1e-12);
      ASSERT_GE(std::abs(at.k1_per_m), std::abs(at.k2_per_m));
      ASSERT_LE(std::abs(at.k1_per_m), kSharpest_per_m);
    });
  }
}

// Along the surface the normal turns by k1 t1 along t1 and by k2 t2 along t2. By differences over 0.2 um, whose error
// is that of the third derivative: not where curvature itself grows within micrometres.
TEST(ExactShape, CurvaturesAreHowTheNormalTurns) {
  constexpr double kStep_m = 0.1e-6;
  for (const Case& one : cases()) {
    int compared = 0;
    for_samples(one, 3, [&](const Vector3d& s, const Vector3d& /*n*/, int face) {
      if (has_creases(one) && s.cwiseAbs().minCoeff() < 1e-3) return;
      ++compared;
      const SurfaceForm at = foot_on_face(one.shape, face, s, s);
      for (const bool first : {true, false}) {
        const Vector3d t = first ? at.t1 : Vector3d(at.normal.cross(at.t1));
        const Vector3d ahead = foot_on_face(one.shape, face, s + kStep_m * t, s).normal;
        const Vector3d behind = foot_on_face(one.shape, face, s - kStep_m * t, s).normal;
        const double k = first ? at.k1_per_m : at.k2_per_m;
        // Rounding of normals, 1e-16, over the step is 1e-9 per metre; ten times that for its growth on the way.
        ASSERT_LT(((ahead - behind) / (2.0 * kStep_m) - k * t).norm(), 1e-4 * std::abs(at.k1_per_m) + 1e-7)
            << "s " << s.transpose() << " k " << k;
      }
    });
    EXPECT_GT(compared, 500) << one.name;
  }
}

// K = 1 / (abc)^2 (x^2/a^4 + y^2/b^4 + z^2/c^4)^-2.
TEST(ExactShape, AnEllipsoidHasTheGaussCurvatureOfTheTextbook) {
  for (const Case& one : cases()) {
    const auto* body = std::get_if<EllipsoidShape>(&one.shape);
    if (body == nullptr) continue;
    const Vector3d a = 0.5 * body->size_m;
    for_samples(one, 1, [&](const Vector3d& s, const Vector3d& /*n*/, int face) {
      const SurfaceForm at = foot_on_face(one.shape, face, s, s);
      const double q = s.cwiseAbs2().cwiseQuotient(a.cwiseAbs2().cwiseAbs2()).sum();
      const double K = 1.0 / (a.prod() * a.prod() * q * q);
      ASSERT_NEAR(at.k1_per_m * at.k2_per_m, K, 1e-11 * K);
    });
  }
}

TEST(ExactShape, AHandleIsASaddleInsideItsRing) {
  const double R = kMug.handle->radius_m, r = 0.5 * kMug.handle->thickness_m;
  const auto at = [&](double from_middle_m) {
    const Vector3d s(kMug.radius_m + from_middle_m, 0.0, 0.0);
    return foot_on_face(kMug, 5, s, s);
  };
  EXPECT_NEAR(at(R - r).k1_per_m, 1.0 / r, 1e-9);
  EXPECT_NEAR(at(R - r).k2_per_m, -1.0 / (R - r), 1e-9);
  EXPECT_NEAR(at(R + r).k2_per_m, 1.0 / (R + r), 1e-9);
  EXPECT_NEAR(std::abs(at(R - r).t1[2]), 0.0, 1e-12);  // Around the rod, not along the ring.
}

/// How far a sample is from the edges of its own face, as the shapes are made.
double to_edge_m(const ExactShape& shape, const Vector3d& s, const Vector3d& n) {
  const double rho = s.head<2>().norm();
  const bool level = std::abs(n[2]) > 0.999;
  if (const auto* box = std::get_if<BoxShape>(&shape)) {
    Vector3d room = 0.5 * box->size_m - s.cwiseAbs();
    Index axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    room[axis] = 1.0;
    return room.minCoeff();
  }
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape))
    return level ? cylinder->radius_m - rho : 0.5 * cylinder->length_m - std::abs(s[2]);
  const auto* mug = std::get_if<Mug>(&shape);
  if (mug == nullptr) return 1.0;
  const double half_m = 0.5 * mug->height_m, inner_m = mug->radius_m - mug->wall_m;
  const bool handle = mug->handle && std::abs(off_face_m(shape, 5, s)) < 1e-9 && rho > mug->radius_m + 1e-9;
  if (handle) return rho - mug->radius_m;
  const double seam_m = mug->handle && rho > mug->radius_m - 1e-9 ? off_face_m(shape, 5, s) : 1.0;
  if (level) {
    const double to_outer_m = mug->radius_m - rho;
    if (s[2] < -half_m + 1e-9) return to_outer_m;
    return s[2] > half_m - 1e-9 ? std::min(to_outer_m, rho - inner_m) : inner_m - rho;
  }
  if (rho < mug->radius_m - 1e-9) return std::min(half_m - s[2], s[2] + half_m - mug->wall_m);
  return std::min(half_m - std::abs(s[2]), seam_m);
}

// Samples have a face if and only if they are farther than the margin from its edges; it is the one that they are on,
// also if they are a tenth of a millimetre off, with a normal that leans by 20 degrees.
TEST(ExactShape, SamplesAwayFromEdgesHaveTheirFace) {
  const double margin_m = 1e-3;
  Random random(4);
  for (const Case& one : cases()) {
    SCOPED_TRACE(one.name);
    for (Index i = 0; i < one.cloud.points_m.cols(); ++i) {
      const Vector3d s = one.cloud.points_m.col(i), n = one.cloud.normals.col(i);
      const int face = face_at(one.shape, s, n, margin_m);
      const double room_m = to_edge_m(one.shape, s, n);
      ASSERT_EQ(face >= 0, room_m >= margin_m) << "s " << s.transpose() << " room " << room_m;
      if (face < 0) continue;
      ASSERT_LT(std::abs(off_face_m(one.shape, face, s)), 1e-15);
      if (room_m < margin_m + 0.2e-3) continue;
      const Vector3d leaning = (n + std::tan(20.0 * std::numbers::pi / 180.0) * n.unitOrthogonal()).normalized();
      ASSERT_EQ(face_at(one.shape, s + 0.1e-3 * random.direction(), leaning, margin_m), face) << "seed 4";
      ASSERT_EQ(face_at(one.shape, s + 2e-3 * n, n, margin_m), -1);
    }
  }
}

TEST(ExactShape, ThinWallsHaveTwoFaces) {
  const Mug thin{30e-3, 80e-3, 0.2e-3, std::nullopt};
  const Vector3d s(30e-3, 0.0, 5e-3);
  EXPECT_EQ(face_at(thin, s, Vector3d::UnitX(), 1e-3), 1);
  EXPECT_EQ(face_at(thin, s, -Vector3d::UnitX(), 1e-3), 3);
  EXPECT_EQ(face_at(thin, s, Vector3d::UnitY(), 1e-3), -1);
  EXPECT_EQ(face_at(thin, {0.0, 0.0, -40e-3}, -Vector3d::UnitZ(), 1e-3), 0);
  EXPECT_EQ(face_at(thin, {0.0, 0.0, -40e-3}, Vector3d::UnitZ(), 1e-3), 4);
}

// Middles, axes and rings, where directions are undefined, and points as far away as numbers go.
TEST(ExactShape, NothingIsUndefined) {
  const double ring_m = kMug.radius_m + kMug.handle->radius_m;
  std::vector<Vector3d> places{Vector3d::Zero(),
                               {kMug.radius_m, 0.0, 0.0},
                               {ring_m, 0.0, 0.0},
                               {kMug.radius_m, 0.0, kMug.handle->radius_m},
                               {kMug.radius_m, 7e-3, 0.0}};
  for (const double d : {5e-324, 1e-300, 1e-160, 1e-20, 1e-9, 1e-3, 20e-3, 25e-3, 30e-3, 0.3, 1e6, 1e160, 1e308}) {
    for (int signs = 1; signs < 27; ++signs) {
      const int y = signs / 3 % 3 - 1, z = signs / 9 - 1;
      const Vector3d way(signs % 3 - 1, y, z);
      places.emplace_back(d * way);
    }
  }
  const std::vector<Vector3d> starts{Vector3d::Zero(),   places[1],           places[3],
                                     {0.0, 1e-300, 0.0}, {-1e308, 0.0, 1e-3}, {12e-3, 10e-3, -20e-3}};
  const auto is_defined = [](const SurfaceForm& at) {
    return std::isfinite(at.distance_m) && at.point_m.allFinite() && std::abs(at.normal.norm() - 1.0) < 1e-9 &&
           std::abs(at.t1.norm() - 1.0) < 1e-9 && std::abs(at.t1.dot(at.normal)) < 1e-6 &&
           std::abs(at.k1_per_m) <= kSharpest_per_m && std::abs(at.k2_per_m) <= kSharpest_per_m &&
           std::abs(at.k1_per_m) >= std::abs(at.k2_per_m);
  };
  for (const Case& one : cases()) {
    SCOPED_TRACE(one.name);
    const int faces = std::holds_alternative<BoxShape>(one.shape)        ? 6
                      : std::holds_alternative<CylinderShape>(one.shape) ? 3
                      : !std::holds_alternative<Mug>(one.shape)          ? 1
                      : std::get<Mug>(one.shape).handle                  ? 6
                                                                         : 5;
    for (const Vector3d& x : places) {
      ASSERT_TRUE(is_defined(nearest_place(one.shape, x))) << x.transpose();
      ASSERT_GE(face_at(one.shape, x, Vector3d::UnitX(), 1e-3), -1);
      for (const Vector3d& near : starts) {
        for (int face = 0; face < faces; ++face)
          ASSERT_TRUE(is_defined(foot_on_face(one.shape, face, x, near))) << x.transpose() << ", " << near.transpose();
        if (testing::Test::HasFailure()) return;
      }
    }
  }
}

TEST(ExactShape, AllocatesNothing) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  for (const Case& one : cases()) {
    const Vector3d s = one.cloud.points_m.col(7), n = one.cloud.normals.col(7);
    const AllocationCounter allocations;
    const int face = std::max(0, face_at(one.shape, s, n, 0.0));
    double sum_m = foot_on_face(one.shape, face, s + 1e-3 * n, s).distance_m;
    sum_m += nearest_place(one.shape, s - 1e-3 * n).distance_m;
    EXPECT_EQ(allocations.count(), 0) << one.name << sum_m;
  }
}

}  // namespace
}  // namespace thenar::exact_shapes
