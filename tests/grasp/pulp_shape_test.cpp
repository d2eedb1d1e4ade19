// SPDX-License-Identifier: Apache-2.0
// Pulps that are ellipsoids and capsules: their surfaces, control points, and where they touch.

#include "collision/pulp_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "collision/shapes.h"
#include "engine/grasp/pulp.h"
#include "engine/grasp/pulp_touch.h"
#include "engine/hand/hand.h"
#include "tests/support/scenes.h"

namespace thenar::pulp_shape_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

PulpShape ellipsoid(const Vector3d& mm, const Matrix3d& axes = Matrix3d::Identity()) {
  return {PulpShape::Form::kEllipsoid, axes, 1e-3 * mm};
}
PulpShape capsule(double half_mm, double radius_mm, const Matrix3d& axes = Matrix3d::Identity()) {
  return {PulpShape::Form::kCapsule, axes, 1e-3 * Vector3d(half_mm, radius_mm, radius_mm)};
}

Fingertip tip_of(const PulpShape& shape) {
  Fingertip tip;
  tip.centre_m = {1e-3, 2e-3, 0.0};
  tip.radius_m = shape.inner_radius_m();
  tip.shape = shape;
  tip.normal = Vector3d::UnitY();
  return tip;
}

std::vector<PulpShape> shapes() {
  std::mt19937_64 random(11);
  return {ellipsoid({11, 8, 6.5}, random_rotation(random)), ellipsoid({8, 8, 8}, random_rotation(random)),
          ellipsoid({12, 12, 4}, random_rotation(random)),  ellipsoid({12, 3, 3}, random_rotation(random)),
          ellipsoid({9, 8, 7}, random_rotation(random)),    capsule(6, 7, random_rotation(random)),
          capsule(0.1, 8, random_rotation(random)),         capsule(20, 6, random_rotation(random))};
}

/// Less than 0 inside, rising outward: a function that is 0 on the surface, apart from what is tested.
double level(const PulpShape& shape, const Vector3d& x_m) {
  const Vector3d y = shape.axes.transpose() * x_m;
  if (shape.form == PulpShape::Form::kEllipsoid) return y.cwiseQuotient(shape.half_m).norm() - 1.0;
  const double over_m = std::max(0.0, std::abs(y[0]) - shape.half_m[0]);
  return std::hypot(over_m, y[1], y[2]) / shape.half_m[1] - 1.0;
}

Vector3d gradient(const PulpShape& shape, const Vector3d& x_m) {
  constexpr double kStep_m = 1e-7;
  Vector3d g;
  for (int i = 0; i < 3; ++i) {
    const Vector3d step = kStep_m * Vector3d::Unit(i);
    g[i] = level(shape, x_m + step) - level(shape, x_m - step);
  }
  return g.normalized();
}

/// The area by the midpoint rule over x = cos(theta) along the first axis and the angle about it: of an ellipsoid by
/// the stretch of the unit sphere's area a b c |A^-1 u|, which the rule takes with an error of the square of its step.
double area_by_quadrature_m2(const PulpShape& shape) {
  if (shape.form == PulpShape::Form::kCapsule) {
    return 2.0 * kPi * shape.half_m[1] * 2.0 * shape.half_m[0] + 4.0 * kPi * shape.half_m[1] * shape.half_m[1];
  }
  constexpr int kSteps = 1000;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double z = 2.0 * (i + 0.5) / kSteps - 1.0, r = std::sqrt(1.0 - z * z);
    for (int j = 0; j < kSteps; ++j) {
      const double turn = 2.0 * kPi * (j + 0.5) / kSteps;
      const Vector3d u(r * std::cos(turn), r * std::sin(turn), z);
      sum += u.cwiseQuotient(shape.half_m).norm();
    }
  }
  return shape.half_m.prod() * 4.0 * kPi / kSteps / kSteps * sum;
}

TEST(PulpShape, NearestPlacesAreOnTheSurfaceAndStraightBelow) {
  std::mt19937_64 random(1);
  for (const PulpShape& shape : shapes()) {
    const double size_m = shape.outer_radius_m();
    for (int i = 0; i < 2000; ++i) {
      const Vector3d x_m = uniform(random, 0.02, 2.0) * size_m * random_direction(random);
      const PulpPlace place = nearest_place(shape, x_m);
      EXPECT_NEAR(level(shape, place.point_m), 0.0, 1e-12);
      EXPECT_NEAR(place.normal.norm(), 1.0, 1e-14);
      EXPECT_LE((place.point_m + place.distance_m * place.normal - x_m).norm(), 1e-12 * size_m);
      EXPECT_EQ(place.distance_m < 0.0, level(shape, x_m) < 0.0);
      // No other place of the surface is nearer.
      for (int j = 0; j < 10; ++j) {
        const Vector3d other_m = support_m(shape, random_direction(random));
        EXPECT_GE((other_m - x_m).norm(), std::abs(place.distance_m) - 1e-12 * size_m);
      }
    }
  }
}

TEST(PulpShape, NormalsAreTheGradients) {
  std::mt19937_64 random(2);
  for (const PulpShape& shape : shapes()) {
    for (int i = 0; i < 500; ++i) {
      const Vector3d n = random_direction(random), s = support_m(shape, n);
      EXPECT_NEAR(level(shape, s), 0.0, 1e-12);
      // The gradient of differences over 2e-7 m errs by the square of that over the least radius, and by rounding.
      EXPECT_LE((gradient(shape, s) - n).norm(), 1e-6);
      EXPECT_NEAR(extent_m(shape, n), n.dot(s), 1e-15);
      for (int j = 0; j < 10; ++j) {
        EXPECT_LE(n.dot(support_m(shape, random_direction(random))), extent_m(shape, n) + 1e-15);
      }
      EXPECT_LE(s.norm(), shape.outer_radius_m() + 1e-15);
      EXPECT_GE(s.norm(), shape.inner_radius_m() - 1e-15);
    }
  }
}

// Over a small step along a principal direction the surface falls by its square over twice the radius.
TEST(PulpShape, CurvatureIsHowTheSurfaceFalls) {
  std::mt19937_64 random(3);
  for (const PulpShape& shape : shapes()) {
    if (shape.form == PulpShape::Form::kCapsule) continue;
    for (int i = 0; i < 200; ++i) {
      const Vector3d n = random_direction(random), s = support_m(shape, n);
      const PulpCurvature at = curvature(shape, n);
      EXPECT_GE(at.radii_m[0], at.radii_m[1]);
      EXPECT_LE((at.directions.transpose() * n).norm(), 1e-12);
      EXPECT_NEAR(at.directions.col(0).dot(at.directions.col(1)), 0.0, 1e-12);
      for (int axis = 0; axis < 2; ++axis) {
        // Both ways, so that the third order falls out; the fourth is the square of the step over the least radius.
        const double step_m = 1e-3 * at.radii_m[1];
        double fall_m = 0.0;
        for (const double side : {-1.0, 1.0}) {
          const Vector3d x_m = s + side * step_m * at.directions.col(axis);
          fall_m += 0.5 * nearest_place(shape, x_m).distance_m;
        }
        EXPECT_NEAR(fall_m / (0.5 * step_m * step_m / at.radii_m[axis]), 1.0, 1e-4);
      }
    }
  }
  // A capsule's ends are round, and so is it across.
  const PulpShape round = capsule(6, 7);
  EXPECT_NEAR(curvature(round, Vector3d::UnitX()).radii_m[0], 7e-3, 1e-15);
  EXPECT_NEAR(curvature(round, Vector3d::UnitY()).radii_m[1], 7e-3, 1e-15);
  EXPECT_GT(curvature(round, Vector3d::UnitY()).radii_m[0], 13e-3);
}

// Control points stand for all of the surface, lie on it with its normals, and evenly: neither their areas nor their
// distances differ more than those of the spherical pulp do, by 10 % rms, although it is bent differently everywhere.
// With 64 of them those of the flattest shape, whose cells are as wide as its rim is thick, differ by 20 %.
TEST(PulpShape, ControlPointsCoverTheSurfaceEvenly) {
  for (const PulpShape& shape : shapes()) {
    const double area = area_by_quadrature_m2(shape);
    EXPECT_NEAR(area_m2(shape) / area, 1.0, 1e-5);
    const Vector3d centre_m(2e-3, -1e-3, 3e-3);
    Pulp pulp = make_pulp(centre_m, shape.inner_radius_m(), shape, 2400, 320, {0.24e6, 0.5, 0.0});
    for (const int at : {0, 1, 2}) {
      if (at > 0) set_level(pulp, at);
      const Index n = pulp.controls();
      SCOPED_TRACE(testing::Message() << shape.half_m.transpose() << " m, level " << at << ", " << n);
      EXPECT_NEAR(pulp.area_m2.sum() / area, 1.0, 1e-5);
      const double mean_m2 = area / static_cast<double>(n);
      double nearest_m = 1.0;
      for (Index i = 0; i < n; ++i) {
        const Vector3d x_m = pulp.control_points_m.col(i) - centre_m;
        EXPECT_NEAR(level(shape, x_m), 0.0, 1e-12);
        EXPECT_LE((gradient(shape, x_m) - pulp.control_normals.row(i).transpose()).norm(), 1e-6);
        EXPECT_NEAR(pulp.area_m2[i] / mean_m2, 1.0, 0.5);
        for (Index j = 0; j < i; ++j) {
          nearest_m = std::min(nearest_m, (pulp.control_points_m.col(i) - pulp.control_points_m.col(j)).norm());
        }
      }
      // On a hexagonal lattice they are 1.07 of the area's root apart.
      EXPECT_GT(nearest_m, 0.4 * std::sqrt(mean_m2));
      const Eigen::VectorXd share = pulp.area_m2 / mean_m2;
      EXPECT_LT(std::sqrt((share.array() - 1.0).square().mean()), at < 2 ? 0.13 : 0.22);
    }
  }
}

/// The area that is nearer to each control point than to the others, by many even samples.
Eigen::VectorXd areas_by_counting_m2(const PulpShape& shape, const Pulp& pulp, Index samples) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(pulp.controls());
  const PointCloud cloud = sample_pulp(shape, samples);
  for (Index i = 0; i < samples; ++i) {
    Index c = 0;
    (pulp.control_points_m.colwise() - cloud.points_m.col(i)).colwise().squaredNorm().minCoeff(&c);
    areas[c] += area_m2(shape) / static_cast<double>(samples);
  }
  return areas;
}

// An area is what is nearest to its control point. 60 000 samples that keep their distance fill 80 cells with 750
// each, of which those on its border, about 4 sqrt(750), may be its neighbours': half of them at random is 0.7 % in the
// mean over the cells; as much again is allowed for cells that the surface bends in, and six times of that in one.
TEST(PulpShape, AreasAreWhatIsNearest) {
  for (const PulpShape& shape : {ellipsoid({11, 8, 6.5}), ellipsoid({12, 6, 6}), capsule(6, 7)}) {
    const Pulp pulp = make_pulp(Vector3d::Zero(), shape.inner_radius_m(), shape, 600, 80, {0.24e6, 0.5, 0.0});
    const Eigen::VectorXd counted = areas_by_counting_m2(shape, pulp, 60'000);
    const Eigen::ArrayXd error = pulp.area_m2.cwiseQuotient(counted).array() - 1.0;
    EXPECT_LT(std::sqrt(error.square().mean()), 0.014) << shape.half_m.transpose();
    EXPECT_LT(error.abs().maxCoeff(), 0.06) << shape.half_m.transpose();
  }
}

// With equal semi-axes, or hardly any straight part, it is the spherical pulp, whose points lie elsewhere.
TEST(PulpShape, RoundShapesAreSpheres) {
  std::mt19937_64 random(5);
  for (const PulpShape& shape : {ellipsoid({8, 8, 8}), capsule(1e-9, 8)}) {
    const Fingertip tip = tip_of(shape);
    Fingertip sphere = tip;
    sphere.shape.reset();
    sphere.radius_m = 8e-3;
    EXPECT_NEAR(area_m2(shape) / (4.0 * kPi * 64e-6), 1.0, 1e-9);
    EXPECT_NEAR(round_radius_m(tip), 8e-3, 1e-11);
    for (int i = 0; i < 100; ++i) {
      const Vector3d x_m = 0.02 * random_direction(random), n = random_direction(random);
      const PulpPlace a = nearest_place(tip, x_m), b = nearest_place(sphere, x_m);
      EXPECT_LE((a.point_m - b.point_m).norm() + (a.normal - b.normal).norm(), 1e-8);
      EXPECT_NEAR(a.distance_m, b.distance_m, 1e-11);
      EXPECT_NEAR(extent_m(tip, n), 8e-3, 1e-11);
    }
  }
}

TEST(PulpShape, TheMirroredHandHasMirroredPulps) {
  Hand hand = scene_of("box_grasp").hand;
  std::mt19937_64 random(6);
  const Matrix3d turned = random_rotation(random);
  hand.fingertips[0].shape = ellipsoid({11, 8, 6.5}, turned);
  hand.fingertips[1].shape = capsule(6, 7, turned);
  const Hand other = mirrored(hand);
  const Eigen::DiagonalMatrix<double, 3> M(1.0, 1.0, -1.0);
  for (int k = 0; k < 2; ++k) {
    const PulpShape& shape = *hand.fingertips[k].shape;
    const PulpShape& image = *other.fingertips[k].shape;
    EXPECT_NEAR(image.axes.determinant(), 1.0, 1e-12);
    EXPECT_EQ(image.half_m, shape.half_m);
    for (int i = 0; i < 100; ++i) {
      const Vector3d n = random_direction(random), x_m = 0.02 * random_direction(random);
      EXPECT_LE((support_m(image, M * n) - M * support_m(shape, n)).norm(), 1e-15);
      const PulpPlace place = nearest_place(shape, x_m), mirrored_place = nearest_place(image, M * x_m);
      EXPECT_LE((mirrored_place.point_m - M * place.point_m).norm(), 1e-14);
      EXPECT_LE((mirrored_place.normal - M * place.normal).norm(), 1e-12);
    }
  }
}

/// The least signed distance of the pulp's own points from an object: of many supports around the best of many.
double least_gap_m(const Fingertip& tip, const ImplicitSurface& object, const Isometry3d& X_OF) {
  std::mt19937_64 random(8);
  Vector3d best = tip.normal;
  const auto gap_m = [&](const Vector3d& n) {
    double gap = object.distance(X_OF * (tip.centre_m + support_m(*tip.shape, n)), 1.0)->distance_m;
    if (tip.shape->form != PulpShape::Form::kCapsule) return gap;
    // Where the normal is across the capsule, all its line.
    for (int i = -10; i <= 10; ++i) {
      const Vector3d on_line = 0.1 * i * tip.shape->half_m[0] * tip.shape->axes.col(0);
      gap = std::min(gap, object.distance(X_OF * (tip.centre_m + on_line + tip.shape->half_m[1] * n), 1.0)->distance_m);
    }
    return gap;
  };
  double least = std::numeric_limits<double>::infinity();
  for (double spread = 2.0; spread > 1e-4; spread *= 0.7) {
    const Vector3d about = best;
    for (int i = 0; i < 60; ++i) {
      const Vector3d n = (about + spread * random_direction(random)).normalized();
      const double gap = gap_m(n);
      if (gap >= least) continue;
      least = gap;
      best = n;
    }
  }
  return least;
}

// The ball touches where the pulp does: its distance is the least one of the pulp's surface, outside of the object and
// pressed in a little. Distances are those of sampled surfaces of 6000 points, which seen from the ball's middle and
// from its surface differ by some micrometres. A capsule that is nearly parallel to the surface may be taken at another
// place of its line: at most by its slope there, 0.02, times a quarter of its half.
TEST(PulpShape, TheBallTouchesWhereThePulpIsNearest) {
  const std::vector<ImplicitSurface> objects{
      ImplicitSurface(sample_sphere(15e-3, 6000)), ImplicitSurface(sample_ellipsoid({40e-3, 50e-3, 60e-3}, 6000)),
      ImplicitSurface(sample_superquadric({50e-3, 40e-3, 60e-3}, {0.6, 0.6}, 6000))};
  std::mt19937_64 random(7);
  int looked = 0;
  for (const PulpShape& shape :
       {ellipsoid({11, 8, 6.5}), ellipsoid({9, 8, 7}), ellipsoid({8, 8, 8}), capsule(5, 7), capsule(12, 5)}) {
    const Fingertip tip = tip_of(shape);
    const double slack_m = shape.form == PulpShape::Form::kCapsule ? 0.02 * 0.25 * shape.half_m[0] : 0.0;
    for (const ImplicitSurface& object : objects) {
      for (int i = 0; i < 8; ++i) {
        Isometry3d X_OF = Isometry3d::Identity();
        X_OF.linear() = random_rotation(random);
        const auto sample = static_cast<Index>(uniform(random, 0.0, 0.999) * 6000.0);
        const Vector3d n_O = object.cloud().normals.col(sample);
        const double reach_m = extent_m(shape, X_OF.linear().transpose() * n_O);
        X_OF.translation() = object.cloud().points_m.col(sample) + (reach_m + uniform(random, -0.5e-3, 1e-3)) * n_O -
                             X_OF.linear() * tip.centre_m;
        const PulpBall ball = touching_ball(tip, object, X_OF);
        const double gap_m = object.distance(X_OF * ball.centre_m, 1.0)->distance_m - ball.radius_m;
        EXPECT_NEAR(gap_m, least_gap_m(tip, object, X_OF), 10e-6 + slack_m)
            << shape.half_m.transpose() << "; " << object.bounds().sizes().transpose() << "; " << i;
        ++looked;
      }
    }
  }
  EXPECT_EQ(looked, 120);
}

// A capsule that lies on a face touches in its middle, and moves to an end as it is tilted by 1 degree, without a step.
TEST(PulpShape, ACapsuleOnAFaceTouchesInItsMiddle) {
  const ImplicitSurface box(sample_box({60e-3, 60e-3, 60e-3}, 8000));
  Fingertip tip = tip_of(capsule(6, 7));
  tip.centre_m.setZero();
  double before = 0.0;
  for (int i = 0; i <= 60; ++i) {
    Isometry3d X_OF = Isometry3d::Identity();
    X_OF.linear() = Eigen::AngleAxisd(0.4e-3 * i, Vector3d::UnitY()).toRotationMatrix();
    X_OF.translation() = Vector3d(1e-3, 2e-3, 37e-3);
    const PulpBall ball = touching_ball(tip, box, X_OF);
    EXPECT_EQ(ball.radius_m, 7e-3);
    const double share = ball.centre_m.x() / 6e-3;
    if (i == 0) {
      EXPECT_NEAR(share, 0.0, 1e-3);
    } else if (i > 52) {
      EXPECT_NEAR(share, 1.0, 1e-6);
    }
    EXPECT_NEAR(share - before, 0.0, 0.03);
    before = share;
  }
}

}  // namespace
}  // namespace thenar::pulp_shape_test
