// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collision/point_cloud.h"
#include "thenar/eigen_layout.h"

namespace thenar {

/// The shape of a pulp that is not a sphere: convex, and symmetric in three planes through its centre. Points below are
/// relative to that centre, in the axes of the distal frame.
struct PulpShape {
  enum class Form {
    kEllipsoid,
    kCapsule,  ///< All points within a radius of a straight line.
  };
  Form form = Form::kEllipsoid;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< Columns; right-handed. A capsule lies along the first.
  /// Half sizes along these axes: the semi-axes of an ellipsoid; half the line of a capsule, then twice its radius.
  Eigen::Vector3d half_m = Eigen::Vector3d::Zero();

  /// Return the radii of the largest sphere about the centre inside the pulp and of the smallest one around it.
  [[nodiscard]] double inner_radius_m() const;
  [[nodiscard]] double outer_radius_m() const;

  bool operator==(const PulpShape&) const = default;
};

/// A point on a pulp's surface.
struct PulpPlace {
  Eigen::Vector3d point_m, normal;
  double distance_m = 0.0;  ///< Signed distance of the query point; negative inside.
};

/// Finds the surface's nearest point to x, to rounding; one of them if several are as near.
[[nodiscard]] PulpPlace nearest_place(const PulpShape& shape, const Eigen::Vector3d& x_m);

/// Returns the surface point whose outward normal is n (unit). Across a capsule it is the middle of a line of these.
[[nodiscard]] Eigen::Vector3d support_m(const PulpShape& shape, const Eigen::Vector3d& n);

/// Returns the extent of the pulp in the direction n (unit): n . support_m().
[[nodiscard]] double extent_m(const PulpShape& shape, const Eigen::Vector3d& n);

/// The principal radii of curvature where the normal is n, the larger first, and their directions. Along a capsule,
/// which is straight, the radius is that of the ellipsoid of revolution of its length and thickness, to scale patches.
struct PulpCurvature {
  Eigen::Vector2d radii_m;
  Eigen::Matrix<double, 3, 2> directions;
};
[[nodiscard]] PulpCurvature curvature(const PulpShape& shape, const Eigen::Vector3d& n);

/// Computes the force over E* that presses a capsule to a depth on a rigid plane across n: that of a sphere of its
/// radius, and 0.4 times the depth times the length of its straight part in the plane: nearly a line contact, whose
/// force is proportional to depth. Within 10 % of pressed pulps of a radius of 7 mm that lie flat, up to 8 mm of half
/// length and 2 mm deep.
[[nodiscard]] double capsule_load_m2(const PulpShape& capsule, const Eigen::Vector3d& n, double depth_m);
/// Computes the depth by a load, the inverse of capsule_load_m2(), up to the radius.
[[nodiscard]] double capsule_depth_m(const PulpShape& capsule, const Eigen::Vector3d& n, double load_m2);

/// Returns the area of the whole surface.
[[nodiscard]] double area_m2(const PulpShape& shape);

/// Returns `count` even samples of the surface, relative to the centre.
[[nodiscard]] PointCloud sample_pulp(const PulpShape& shape, Eigen::Index count);

}  // namespace thenar
