// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "collision/point_cloud.h"

/// Surfaces of simple solids as exactly `count` blue-noise samples, on the surface and with its normals to rounding.
/// Solids are centred on the origin; same seed, same cloud. Sizes are full sizes along x, y, z; an axis of revolution
/// is z. All throw std::invalid_argument for an invalid solid and for count < 1.
namespace thenar {

[[nodiscard]] PointCloud sample_box(const Eigen::Vector3d& size_m, Eigen::Index count, std::uint32_t seed = 1);

[[nodiscard]] PointCloud sample_sphere(double radius_m, Eigen::Index count, std::uint32_t seed = 1);

struct EllipsoidShape {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  bool operator==(const EllipsoidShape&) const = default;
};
[[nodiscard]] PointCloud sample_ellipsoid(const Eigen::Vector3d& size_m, Eigen::Index count, std::uint32_t seed = 1);

[[nodiscard]] PointCloud sample_cylinder(double radius_m, double length_m, Eigen::Index count, std::uint32_t seed = 1);

/// Roundness of a superquadric: 0 of a box, 1 of an ellipsoid, 2 of an octahedron.
struct Exponents {
  double north_south = 1.0;  ///< e1: sections along z.
  double east_west = 1.0;    ///< e2: sections across z.
  bool operator==(const Exponents&) const = default;
};
inline constexpr double kLeastExponent = 0.1, kLargestExponent = 2.0;

struct SuperquadricShape {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  Exponents exponents;
  bool operator==(const SuperquadricShape&) const = default;
};

/// Samples the superquadric ellipsoid [Barr 1981]: ((x/a)^(2/e2) + (y/b)^(2/e2))^(e2/e1) + (z/c)^(2/e1) = 1 with half
/// sizes a, b, c. Between the bounds on exponents it is convex.
[[nodiscard]] PointCloud sample_superquadric(const Eigen::Vector3d& size_m, const Exponents& exponents,
                                             Eigen::Index count, std::uint32_t seed = 1);

/// A ring that protrudes from a mug's wall, in the plane y = 0 at half height: the part of a torus around (radius, 0,
/// 0) that is outside of the wall.
struct MugHandle {
  double radius_m = 0.0;     ///< Distance from the ring's centre, on the wall, to the middle of the rod.
  double thickness_m = 0.0;  ///< Diameter of the rod.
  bool operator==(const MugHandle&) const = default;
};

/// A cylinder with a cylindrical hollow, open at z+; its wall and its floor are equally thick.
struct Mug {
  double radius_m = 0.0;  ///< Outer radius.
  double height_m = 0.0;
  double wall_m = 0.0;
  std::optional<MugHandle> handle;

  /// Tests that the rod leaves a hole in the ring, the ring is not higher than the mug, nor its half wider than the
  /// mug's.
  [[nodiscard]] bool handle_fits() const;
  bool operator==(const Mug&) const = default;
};

/// Returns the centroid of the mug's solid, the handle outside of the wall included, to rounding [m]. Requires a valid
/// mug, see sample_mug.
[[nodiscard]] Eigen::Vector3d centroid_m(const Mug& mug);

[[nodiscard]] PointCloud sample_mug(const Mug& mug, Eigen::Index count, std::uint32_t seed = 1);

}  // namespace thenar
