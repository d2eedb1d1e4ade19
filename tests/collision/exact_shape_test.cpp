#include "collision/solids/exact_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/allocation_counter.h"

namespace thenar::exact_shape_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

const Mug kMug{40e-3, 90e-3, 4e-3, MugHandle{25e-3, 10e-3}};
const double kInner_m = kMug.radius_m - kMug.wall_m, kTop_m = 0.5 * kMug.height_m, kFloor_m = kMug.wall_m - kTop_m;

struct Case {
  std::string name;
  ExactShape shape;
  PointCloud cloud;
};

PointCloud sample(const ExactShape& shape, Index count) {
  return std::visit(
      [&](const auto& body) {
        using Body = std::decay_t<decltype(body)>;
        if constexpr (std::is_same_v<Body, BoxShape>) return sample_box(body.size_m, count);
        if constexpr (std::is_same_v<Body, SphereShape>) return sample_sphere(body.radius_m, count);
        if constexpr (std::is_same_v<Body, EllipsoidShape>) return sample_ellipsoid(body.size_m, count);
        if constexpr (std::is_same_v<Body, CylinderShape>) return sample_cylinder(body.radius_m, body.length_m, count);
        if constexpr (std::is_same_v<Body, SuperquadricShape>)
          return sample_superquadric(body.size_m, body.exponents, count);
        if constexpr (std::is_same_v<Body, Mug>) return sample_mug(body, count);
      },
      shape);
}

/// One of each shape, and superquadrics from nearly a box to an octahedron; with 4000 samples each.
const std::vector<Case>& cases() {
  static const std::vector<Case> kAll = [] {
    std::vector<Case> some;
    const auto add = [&](const char* name, const ExactShape& shape) {
      some.push_back({name, shape, sample(shape, 4000)});
    };
    const Vector3d size_m(40e-3, 50e-3, 60e-3);
    add("box", BoxShape{{50e-3, 60e-3, 80e-3}});
    add("sphere", SphereShape{25e-3});
    add("ellipsoid", EllipsoidShape{size_m});
    add("flat ellipsoid", EllipsoidShape{{20e-3, 80e-3, 50e-3}});
    add("cylinder", CylinderShape{20e-3, 70e-3});
    add("mug", kMug);
    add("mug without a handle", Mug{30e-3, 80e-3, 3e-3, std::nullopt});
    for (const auto& [e1, e2] : {std::pair(0.1, 0.1),
                                 {0.2, 1.0},
                                 {0.3, 0.6},
                                 {0.6, 0.8},
                                 {1.0, 1.0},
                                 {1.0, 0.3},
                                 {0.5, 1.5},
                                 {1.5, 0.5},
                                 {1.3, 1.2},
                                 {1.9, 1.9},
                                 {2.0, 1.0},
                                 {2.0, 2.0}}) {
      add(("superquadric " + std::to_string(e1) + " " + std::to_string(e2)).c_str(),
          SuperquadricShape{size_m, {e1, e2}});
    }
    return some;
  }();
  return kAll;
}

bool is_superquadric(const Case& one) { return std::holds_alternative<SuperquadricShape>(one.shape); }

/// Whether a superquadric's curvature is infinite where it meets a plane of symmetry.
bool has_creases(const Case& one) {
  const auto* shape = std::get_if<SuperquadricShape>(&one.shape);
  return shape != nullptr && (shape->exponents.north_south > 1.0 || shape->exponents.east_west > 1.0);
}

class Random {
 public:
  explicit Random(unsigned seed) : bits_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(bits_); }
  Vector3d in_cube(double half) { return {between(-half, half), between(-half, half), between(-half, half)}; }
  Vector3d direction() { return Vector3d(normal_(bits_), normal_(bits_), normal_(bits_)).normalized(); }

 private:
  std::mt19937 bits_;
  std::normal_distribution<double> normal_;
};

/// How far a place is off the surface of a face, by the textbook's formula: a length that is 0 on it, to first order.
double off_face_m(const ExactShape& shape, int face, const Vector3d& s) {
  const double rho = s.head<2>().norm();
  if (const auto* box = std::get_if<BoxShape>(&shape))
    return s[face / 2] * (face % 2 == 0 ? -1.0 : 1.0) - 0.5 * box->size_m[face / 2];
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return s.norm() - sphere->radius_m;
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) {
    if (face == 0) return rho - cylinder->radius_m;
    return s[2] - (face == 1 ? -0.5 : 0.5) * cylinder->length_m;
  }
  if (const auto* body = std::get_if<EllipsoidShape>(&shape)) {
    const Vector3d half_m = 0.5 * body->size_m;
    return half_m.minCoeff() * (s.cwiseQuotient(half_m).squaredNorm() - 1.0);
  }
  if (const auto* body = std::get_if<SuperquadricShape>(&shape)) {
    const Vector3d a = s.cwiseQuotient(0.5 * body->size_m).cwiseAbs();
    const double e1 = body->exponents.north_south, e2 = body->exponents.east_west;
    const double f = std::pow(std::pow(a[0], 2.0 / e2) + std::pow(a[1], 2.0 / e2), e2 / e1) + std::pow(a[2], 2.0 / e1);
    return 0.5 * body->size_m.minCoeff() * (std::pow(f, 0.5 * e1) - 1.0);
  }
  const auto& mug = std::get<Mug>(shape);
  const double half_m = 0.5 * mug.height_m;
  if (face == 5) {
    const double ring_m = std::hypot(s[0] - mug.radius_m, s[2]) - mug.handle->radius_m;
    return std::hypot(ring_m, s[1]) - 0.5 * mug.handle->thickness_m;
  }
  const std::array<double, 5> off_m{s[2] + half_m, rho - mug.radius_m, s[2] - half_m, rho - mug.radius_m + mug.wall_m,
                                    s[2] - mug.wall_m + half_m};
  return off_m.at(face);
}

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
TEST(ExactShape, NoSampleIsNearerThanTheNearestPlace) {
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
TEST(ExactShape, PlanesProveTheDistancesOfSuperquadrics) {
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
TEST(ExactShape, NormalsAreTheGradientOfTheDistance) {
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
TEST(ExactShape, DistancesAreContinuous) {
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

TEST(ExactShape, EdgesAndCornersAreSharp) {
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
}  // namespace thenar::exact_shape_test
