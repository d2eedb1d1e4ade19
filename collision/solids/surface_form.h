// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "thenar/eigen_layout.h"

namespace thenar {

/// The foot of a point x on a surface, with the surface's second-order form there.
struct SurfaceForm {
  double distance_m = 0.0;                            ///< Distance of x from the foot: > 0 outside, < 0 inside.
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< The foot: x = point + distance normal.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< Outward, unit.
  Eigen::Vector3d t1 = Eigen::Vector3d::UnitX();      ///< First principal direction; the second is normal x t1.
  /// Principal curvatures: > 0 where the solid is convex, |k1| >= |k2|. None is sharper than kSharpest_per_m.
  double k1_per_m = 0.0, k2_per_m = 0.0;
};

/// The curvature that stands for an infinite one: across edges, and creases of superquadrics with exponents above 1.
inline constexpr double kSharpest_per_m = 1e5;

/// Returns the height of x over the paraboloid that approximates a surface around a point, with an error of third order
/// in the distance from there; on circles of fourth.
[[nodiscard]] inline double height_over(const SurfaceForm& form, const Eigen::Vector3d& x_m) {
  const Eigen::Vector3d way = x_m - form.point_m;
  const double along = way.dot(form.t1), across = way.dot(form.normal.cross(form.t1));
  return way.dot(form.normal) + 0.5 * (form.k1_per_m * along * along + form.k2_per_m * across * across);
}

}  // namespace thenar
