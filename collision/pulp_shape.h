#pragma once

#include <Eigen/Core>

#include "collision/point_cloud.h"
#include "thenar/eigen_layout.h"

namespace thenar {

/// A pulp that is no sphere: convex, and symmetric in three planes through its centre. Points below are from that
/// centre, in the axes of the distal frame.
struct PulpShape {
  enum class Form {
    kEllipsoid,
    kCapsule,  ///< All that is within a radius of a straight line.
  };
  Form form = Form::kEllipsoid;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< Columns; right-handed. A capsule lies along the first.
  /// Along these axes: the semi-axes of an ellipsoid. Of a capsule half of its line, and twice the radius.
  Eigen::Vector3d half_m = Eigen::Vector3d::Zero();

  /// Of the largest sphere about the centre that is in the pulp, and of the least one that it is in.
  [[nodiscard]] double inner_radius_m() const;
  [[nodiscard]] double outer_radius_m() const;

  bool operator==(const PulpShape&) const = default;
};

/// A place on a pulp's surface.
struct PulpPlace {
  Eigen::Vector3d point_m, normal;
  double distance_m = 0.0;  ///< Of what it is nearest to; less than 0 inside.
};

/// Where the surface is nearest to a point. To rounding; of equally near places one.
[[nodiscard]] PulpPlace nearest_place(const PulpShape& shape, const Eigen::Vector3d& x_m);

/// Where the outward normal is n (unit). Across a capsule that is a line, of which this is the middle.
[[nodiscard]] Eigen::Vector3d support_m(const PulpShape& shape, const Eigen::Vector3d& n);

/// How far the pulp reaches in the direction n (unit): n . support_m().
[[nodiscard]] double extent_m(const PulpShape& shape, const Eigen::Vector3d& n);

/// The principal radii of curvature where the normal is n, the larger one first, and their directions. Along a capsule
/// it is straight: there the radius is that of the ellipsoid of revolution which is as long and as thick, so that
/// patches have a scale.
struct PulpCurvature {
  Eigen::Vector2d radii_m;
  Eigen::Matrix<double, 3, 2> directions;
};
[[nodiscard]] PulpCurvature curvature(const PulpShape& shape, const Eigen::Vector3d& n);

/// What presses a capsule by a depth on a rigid plane across n, over E*: as a sphere of its radius, and 0.4 times the
/// depth along what of its straight part is in the plane: nearly a line contact, which bears in proportion to depth.
/// Within 10 % of pressed pulps of a radius of 7 mm that lie flat, up to 8 mm of half length and 2 mm deep.
[[nodiscard]] double capsule_load_m2(const PulpShape& capsule, const Eigen::Vector3d& n, double depth_m);
/// Its inverse, up to the radius.
[[nodiscard]] double capsule_depth_m(const PulpShape& capsule, const Eigen::Vector3d& n, double load_m2);

/// Of the whole surface.
[[nodiscard]] double area_m2(const PulpShape& shape);

/// `count` even samples of the surface, about the centre.
[[nodiscard]] PointCloud sample_pulp(const PulpShape& shape, Eigen::Index count);

}  // namespace thenar
