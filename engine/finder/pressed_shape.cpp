// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/pressed_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/grasp/frame.h"
#include "engine/grasp/pulp_touch.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

/// Samples the part of a pulp's surface that is pressed on a plane across n by a depth: about an ellipse.
struct Ellipse {
  Vector3d middle_m, along_m, across_m;
};

Ellipse patch_of(const Fingertip& tip, const Vector3d& n, double depth_m) {
  const PulpShape& shape = *tip.shape;
  const PulpCurvature bends = curvature(shape, n);
  const Eigen::Vector2d half_m = (bends.radii_m * depth_m).cwiseSqrt();
  Ellipse patch{tip.centre_m + support_m(shape, n), half_m[0] * bends.directions.col(0),
                half_m[1] * bends.directions.col(1)};
  if (shape.form == PulpShape::Form::kCapsule) {
    patch.middle_m = tip.centre_m + shape.half_m[1] * n;
    patch.along_m = (shape.half_m[0] + half_m[1]) * shape.axes.col(0);
    patch.across_m = half_m[1] * n.cross(shape.axes.col(0));
  }
  return patch;
}

double free_depth_m(const PulpMaterial& scenes, const Fingertip& tip, double force_N) {
  const PulpMaterial material = material_of(tip, scenes);
  const double E_Pa = material.reduced_modulus_Pa / softness(material, force_N);
  if (tip.shape && tip.shape->form == PulpShape::Form::kCapsule) {
    return capsule_depth_m(*tip.shape, tip.normal, std::max(0.0, force_N) / E_Pa);
  }
  return std::pow(0.75 * std::max(0.0, force_N) / (E_Pa * std::sqrt(round_radius_m(tip))), 2.0 / 3.0);
}

/// The centre and mean normal of the pressure over a patch.
class PressureSum {
 public:
  void add(const SurfaceDistance& at) {
    if (at.distance_m >= 0.0) return;
    const double load = std::sqrt(-at.distance_m);
    centres_ += load * at.point_m;
    normals_ += load * at.normal;
    loads_ += load;
  }

  /// Returns the contact; without pressure at the nearest point.
  [[nodiscard]] GraspContact contact(const Isometry3d& X_WO, const SurfaceDistance& nearest) const {
    const Vector3d centre_O = loads_ > 0.0 ? Vector3d(centres_ / loads_) : nearest.point_m;
    const Vector3d n = -(X_WO.linear() * (loads_ > 0.0 ? Vector3d(normals_.normalized()) : nearest.normal));
    return {X_WO * centre_O, axes_of(n, n.unitOrthogonal())};
  }

 private:
  Vector3d centres_ = Vector3d::Zero(), normals_ = Vector3d::Zero();
  double loads_ = 0.0;
};

}  // namespace

double pressed_depth_m(const std::optional<PulpMaterial>& material, const Fingertip& tip, double force_N) {
  return material ? std::min(free_depth_m(*material, tip, force_N), 0.8 * kTrustPerRadius * tip.radius_m) : 0.0;
}

double greatest_load_N(const std::optional<PulpMaterial>& material, const Fingertip& tip) {
  double low_N = 0.0, high_N = 1e4;
  const auto is_too_deep = [&](double force_N) {
    return material && free_depth_m(*material, tip, force_N) > kTrustPerRadius * tip.radius_m;
  };
  if (!is_too_deep(high_N)) return std::numeric_limits<double>::infinity();
  while (high_N - low_N > 1e-3) {
    const double middle_N = 0.5 * (low_N + high_N);
    (is_too_deep(middle_N) ? high_N : low_N) = middle_N;
  }
  return low_N;
}

double pressed_radius_m(const std::optional<PulpMaterial>& material, const Fingertip& tip, double force_N) {
  const double radius_m = round_radius_m(tip);
  return std::sqrt(radius_m * std::max(pressed_depth_m(material, tip, force_N), 0.01 * radius_m));
}

GraspContact pressed_contact(const ImplicitSurface& object, const Isometry3d& X_WO, const Vector3d& pulp_W,
                             double radius_m) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const Vector3d pulp_O = X_WO.inverse() * pulp_W;
  const SurfaceDistance nearest = *object.distance(pulp_O, kFar);
  const double depth_m = radius_m - nearest.distance_m;
  PressureSum pressure;
  if (depth_m > 0.0) {
    const Vector3d across = nearest.normal.unitOrthogonal(), along = nearest.normal.cross(across);
    const double half_rad = std::sqrt(std::min(1.0, depth_m / radius_m));  // Half angle of the patch on a plane.
    for (int ring = 0; ring <= 2; ++ring) {
      const double angle_rad = 0.5 * ring * half_rad;
      const int points = std::max(1, 6 * ring);
      for (int i = 0; i < points; ++i) {
        const double turn_rad = 2.0 * std::numbers::pi * i / points;
        const Vector3d way = std::cos(angle_rad) * -nearest.normal +
                             std::sin(angle_rad) * (std::cos(turn_rad) * across + std::sin(turn_rad) * along);
        const SurfaceDistance at = *object.distance(pulp_O + radius_m * way + 0.5 * depth_m * nearest.normal, kFar);
        pressure.add(at);
      }
    }
  }
  return pressure.contact(X_WO, nearest);
}

GraspContact pressed_contact(const ImplicitSurface& object, const Isometry3d& X_WO, const Fingertip& tip,
                             const Isometry3d& X_WF) {
  if (!tip.shape) return pressed_contact(object, X_WO, X_WF * tip.centre_m, tip.radius_m);
  constexpr double kFar = std::numeric_limits<double>::infinity();
  constexpr int kRings = 4;
  const Isometry3d X_OF = X_WO.inverse() * X_WF;
  const PulpBall ball = touching_ball(tip, object, X_OF);
  const SurfaceDistance nearest = *object.distance(X_OF * ball.centre_m, kFar);
  const double depth_m = ball.radius_m - nearest.distance_m;
  PressureSum pressure;
  if (depth_m > 0.0) {
    const Ellipse patch = patch_of(tip, X_OF.linear().transpose() * -nearest.normal, depth_m);
    for (int ring = 0; ring <= kRings; ++ring) {
      const double share = static_cast<double>(ring) / kRings;
      const int points = std::max(1, 6 * ring);
      for (int i = 0; i < points; ++i) {
        const double turn_rad = 2.0 * std::numbers::pi * i / points;
        const Vector3d x_F =
            patch.middle_m + share * (std::cos(turn_rad) * patch.along_m + std::sin(turn_rad) * patch.across_m);
        const Vector3d on_O = X_OF * nearest_place(tip, x_F).point_m;
        const SurfaceDistance at = *object.distance(on_O + 0.5 * depth_m * nearest.normal, kFar);
        pressure.add(at);
      }
    }
  }
  return pressure.contact(X_WO, nearest);
}

}  // namespace thenar
