// SPDX-License-Identifier: Apache-2.0
#include "collision/pulp_shape.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "collision/ellipsoid.h"
#include "collision/shapes.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

bool is_capsule(const PulpShape& shape) { return shape.form == PulpShape::Form::kCapsule; }

/// Computes the area of an ellipsoid by Legendre's incomplete elliptic integrals.
double ellipsoid_area_m2(const Vector3d& semi_axes_m) {
  constexpr double kPi = std::numbers::pi, kRound = 1e-6;
  std::array<double, 3> sorted{semi_axes_m[0], semi_axes_m[1], semi_axes_m[2]};
  std::sort(sorted.begin(), sorted.end());
  const auto [c, b, a] = sorted;
  if (a - c < kRound * a) return 4.0 * kPi * std::pow(a * b * c, 2.0 / 3.0);
  const double cosine = c / a, sine = std::sqrt(1.0 - cosine * cosine), phi = std::acos(cosine);
  const double k = std::min(1.0, a / b * std::sqrt((b * b - c * c) / (a * a - c * c)));
  const double F = std::ellint_1(k, phi), E = std::ellint_2(k, phi);
  return 2.0 * kPi * (c * c + a * b / sine * (E * sine * sine + F * cosine * cosine));
}

/// Draws even samples of a capsule. Like a sphere it has the area of the cylinder around it, ring by ring: even samples
/// on that, by the golden angle and a low-discrepancy height, are even on it.
PointCloud sample_capsule(double half_m, double radius_m, Index count) {
  PointCloud cloud{Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd(3, count)};
  const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0)), end_m = half_m + radius_m;
  for (Index i = 0; i < count; ++i) {
    const double x = end_m * ((2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count) - 1.0);
    const double along = std::copysign(std::max(0.0, std::abs(x) - half_m), x) / radius_m;
    const double across = std::sqrt(std::max(0.0, 1.0 - along * along)), angle = turn * static_cast<double>(i);
    cloud.normals.col(i) = Vector3d(along, across * std::cos(angle), across * std::sin(angle));
    cloud.points_m.col(i) = radius_m * cloud.normals.col(i);
    cloud.points_m(0, i) += std::clamp(x, -half_m, half_m);
  }
  return cloud;
}

}  // namespace

double PulpShape::inner_radius_m() const { return form == Form::kCapsule ? half_m[1] : half_m.minCoeff(); }

double PulpShape::outer_radius_m() const { return form == Form::kCapsule ? half_m[0] + half_m[1] : half_m.maxCoeff(); }

PulpPlace nearest_place(const PulpShape& shape, const Vector3d& x_m) {
  const Vector3d y = shape.axes.transpose() * x_m;
  if (is_capsule(shape)) {
    const Vector3d on_line(std::clamp(y[0], -shape.half_m[0], shape.half_m[0]), 0.0, 0.0);
    const Vector3d off = y - on_line;
    const double way_m = off.norm();
    const Vector3d n = way_m > 0.0 ? Vector3d(off / way_m) : Vector3d::UnitY();
    return {shape.axes * (on_line + shape.half_m[1] * n), shape.axes * n, way_m - shape.half_m[1]};
  }
  const Vector3d on = nearest_on_ellipsoid(shape.half_m, y);
  const Vector3d n = on.cwiseQuotient(shape.half_m.cwiseAbs2()).normalized();
  const double side = y.cwiseQuotient(shape.half_m).squaredNorm() < 1.0 ? -1.0 : 1.0;
  return {shape.axes * on, shape.axes * n, side * (y - on).norm()};
}

Vector3d support_m(const PulpShape& shape, const Vector3d& n) {
  const Vector3d m = shape.axes.transpose() * n;
  if (is_capsule(shape)) {
    const double end = m[0] > 0.0 ? 1.0 : m[0] < 0.0 ? -1.0 : 0.0;
    return shape.half_m[1] * n + end * shape.half_m[0] * shape.axes.col(0);
  }
  const Vector3d scaled = shape.half_m.cwiseProduct(m);
  return shape.axes * (shape.half_m.cwiseProduct(scaled) / scaled.norm());
}

double extent_m(const PulpShape& shape, const Vector3d& n) {
  const Vector3d m = shape.axes.transpose() * n;
  if (is_capsule(shape)) return shape.half_m[1] + shape.half_m[0] * std::abs(m[0]);
  return shape.half_m.cwiseProduct(m).norm();
}

PulpCurvature curvature(const PulpShape& shape, const Vector3d& n) {
  Vector3d e = shape.half_m;
  if (is_capsule(shape)) e[0] += e[1];
  // The points move by (A - s s') / h with the normal, A the squared semi-axes, s the support, h the extent: its two
  // eigenvalues across the normal are the radii.
  const Vector3d m = shape.axes.transpose() * n;
  const double h = e.cwiseProduct(m).norm();
  const Vector3d s = e.cwiseAbs2().cwiseProduct(m) / h;
  const Matrix3d turn = (Matrix3d(e.cwiseAbs2().asDiagonal()) - s * s.transpose()) / h;
  Eigen::Matrix<double, 3, 2> plane;
  plane.col(0) = m.unitOrthogonal();
  plane.col(1) = m.cross(plane.col(0));
  const Eigen::Matrix2d across = plane.transpose() * turn * plane;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
  eigen.computeDirect(across);
  PulpCurvature result{eigen.eigenvalues().reverse(), shape.axes * plane * eigen.eigenvectors().rowwise().reverse()};
  if (is_capsule(shape)) result.radii_m = {std::max(result.radii_m[0], e[1]), e[1]};
  return result;
}

double capsule_load_m2(const PulpShape& capsule, const Vector3d& n, double depth_m) {
  constexpr double kLine = 0.4;
  const double tilt = std::min(1.0, std::abs(n.dot(capsule.axes.col(0)))), radius_m = capsule.half_m[1];
  // Where the straight part begins, the round end has risen off the plane.
  const double begins_m = std::max(0.0, depth_m - radius_m * (1.0 - std::sqrt(1.0 - tilt * tilt)));
  const double length_m = std::min(2.0 * capsule.half_m[0], begins_m / std::max(tilt, 1e-9));
  return 4.0 / 3.0 * std::sqrt(radius_m) * std::pow(depth_m, 1.5) +
         kLine * length_m * (begins_m - 0.5 * tilt * length_m);
}

double capsule_depth_m(const PulpShape& capsule, const Vector3d& n, double load_m2) {
  double low = 0.0, high = capsule.half_m[1];
  for (int step = 0; step < 50; ++step) {
    const double middle = 0.5 * (low + high);
    (capsule_load_m2(capsule, n, middle) < load_m2 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double area_m2(const PulpShape& shape) {
  if (!is_capsule(shape)) return ellipsoid_area_m2(shape.half_m);
  return 4.0 * std::numbers::pi * shape.half_m[1] * (shape.half_m[0] + shape.half_m[1]);
}

PointCloud sample_pulp(const PulpShape& shape, Index count) {
  PointCloud cloud = is_capsule(shape) ? sample_capsule(shape.half_m[0], shape.half_m[1], count)
                                       : sample_ellipsoid(2.0 * shape.half_m, count);
  cloud.points_m = (shape.axes * cloud.points_m).eval();
  cloud.normals = (shape.axes * cloud.normals).eval();
  return cloud;
}

}  // namespace thenar
