// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/pulp_touch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

/// The ball that touches an ellipsoid from within where the normal is n, and is as round; about the centre.
PulpBall ball_at(const PulpShape& shape, const Vector3d& n) {
  const double radius_m = std::min(curvature(shape, n).radii_m.mean(), shape.outer_radius_m());
  return {support_m(shape, n) - radius_m * n, radius_m};
}

/// Each ball's own nearest normal is that of the next one. With the mean radius of curvature an error of the normal
/// shrinks by half of what the two radii differ by over their mean and the object's; where it does not, steps are
/// halved.
PulpBall ball_of_ellipsoid(const Fingertip& tip, const ImplicitSurface& object, const Isometry3d& X_OF) {
  constexpr int kMostSteps = 40;
  constexpr double kSame_rad = 1e-7, kSlow = 0.7;
  const PulpShape& shape = *tip.shape;
  const auto normal_at = [&](const Vector3d& offset_m) -> std::optional<Vector3d> {
    const auto at = object.distance(X_OF * (tip.centre_m + offset_m), kFar);
    if (!at) return std::nullopt;  // Normals that cancel.
    return -(X_OF.linear().transpose() * at->normal);
  };
  std::optional<Vector3d> wanted = normal_at(Vector3d::Zero());
  Vector3d n = wanted.value_or(tip.normal);
  PulpBall ball = ball_at(shape, n);
  double share = 1.0, last_rad = kFar;
  for (int step = 0; step < kMostSteps && wanted; ++step) {
    wanted = normal_at(ball.centre_m);
    if (!wanted) break;
    const double turn_rad = (*wanted - n).norm();
    if (turn_rad < kSame_rad) break;
    if (turn_rad > kSlow * last_rad) share = std::max(0.1, 0.5 * share);
    last_rad = turn_rad;
    n = (n + share * (*wanted - n)).normalized();
    ball = ball_at(shape, n);
  }
  return {tip.centre_m + ball.centre_m, ball.radius_m};
}

/// The least distance along the line, as if it bulged by a 100th of its half: between the best of five places and its
/// neighbours there is one where the slope changes its sign.
PulpBall ball_of_capsule(const Fingertip& tip, const ImplicitSurface& object, const Isometry3d& X_OF) {
  constexpr double kFlat = 0.02;  // The slope, 1 degree, from which on it touches with an end.
  constexpr int kSteps = 24;
  const double half_m = tip.shape->half_m[0], radius_m = tip.shape->half_m[1];
  const Vector3d line = tip.shape->axes.col(0);
  struct OnLine {
    double distance_m, slope;
  };
  const auto look = [&](double share) -> OnLine {
    const auto at = object.distance(X_OF * (tip.centre_m + share * half_m * line), kFar);
    if (!at) return {kFar, 0.0};
    return {at->distance_m + 0.5 * kFlat * half_m * share * share,
            at->normal.dot(X_OF.linear() * line) + kFlat * share};
  };
  double best = 0.0, best_m = kFar;
  for (const double share : {0.0, -0.5, 0.5, -1.0, 1.0}) {
    const double distance_m = look(share).distance_m;
    if (distance_m >= best_m) continue;
    best = share;
    best_m = distance_m;
  }
  constexpr double kApart = 0.5;
  double low = std::max(-1.0, best - kApart), high = std::min(1.0, best + kApart);
  const double slope = look(best).slope;
  (slope > 0.0 ? high : low) = best;
  for (int step = 0; step < kSteps && high - low > 1e-9; ++step) {
    const double middle = 0.5 * (low + high);
    (look(middle).slope > 0.0 ? high : low) = middle;
  }
  return {tip.centre_m + 0.5 * (low + high) * half_m * line, radius_m};
}

}  // namespace

PulpBall touching_ball(const Fingertip& tip, const ImplicitSurface& object, const Isometry3d& X_OF) {
  if (!tip.shape) return {tip.centre_m, tip.radius_m};
  return tip.shape->form == PulpShape::Form::kCapsule ? ball_of_capsule(tip, object, X_OF)
                                                      : ball_of_ellipsoid(tip, object, X_OF);
}

PulpPlace nearest_place(const Fingertip& tip, const Vector3d& x_F) {
  const Vector3d way_m = x_F - tip.centre_m;
  PulpPlace place;
  if (tip.shape) {
    place = nearest_place(*tip.shape, way_m);
  } else {
    place.normal = way_m.norm() > 0.0 ? Vector3d(way_m.normalized()) : tip.normal;
    place.point_m = tip.radius_m * place.normal;
    place.distance_m = way_m.norm() - tip.radius_m;
  }
  place.point_m += tip.centre_m;
  return place;
}

double extent_m(const Fingertip& tip, const Vector3d& n) { return tip.shape ? extent_m(*tip.shape, n) : tip.radius_m; }

double outer_radius_m(const Fingertip& tip) { return tip.shape ? tip.shape->outer_radius_m() : tip.radius_m; }

double round_radius_m(const Fingertip& tip) {
  return tip.shape ? std::sqrt(curvature(*tip.shape, tip.normal).radii_m.prod()) : tip.radius_m;
}

}  // namespace thenar
