#pragma once

#include <Eigen/Core>
#include <optional>

#include "collision/shapes.h"
#include "collision/solids/surface_form.h"

namespace thenar {

// Ellipsoids and superquadrics: the nearest places of their surfaces. A superquadric with an exponent above 1 has
// creases where it meets a plane of symmetry: the curvature across them is infinite, and with an exponent of 2 they are
// edges. On a crease, seen from outside, the normal is along x - point.
//
// x and near are finite, and no longer than 1e9 m. None allocates or throws, or gives NaN.

/// The foot of x that Newton's method finds from `near_m`: the distance is least among its neighbours. Outside, and
/// from a start on the side of x, it is the nearest place.
///
/// Accuracy  1e-12 of the size of an ellipsoid; on superquadrics 1e-9 m. Creases of exponents from 1.9 to 2 are nearly
///           edges, and hold the method up: nearest_on() is then some um off in some of 1e5 cases, and a foot, which is
///           found from one start alone, in some of 1e4.
[[nodiscard]] SurfaceForm foot_on(const EllipsoidShape& shape, const Eigen::Vector3d& x_m,
                                  const Eigen::Vector3d& near_m) noexcept;
[[nodiscard]] SurfaceForm foot_on(const SuperquadricShape& shape, const Eigen::Vector3d& x_m,
                                  const Eigen::Vector3d& near_m) noexcept;

/// The place nearest to x. Inside a superquadric it is the foot that is found from `near_m`; without it the nearest of
/// those from starts all over the surface.
[[nodiscard]] SurfaceForm nearest_on(const EllipsoidShape& shape, const Eigen::Vector3d& x_m) noexcept;
[[nodiscard]] SurfaceForm nearest_on(const SuperquadricShape& shape, const Eigen::Vector3d& x_m,
                                     const std::optional<Eigen::Vector3d>& near_m) noexcept;

/// About how far x is from the surface, by its first order: exact on the surface.
[[nodiscard]] double distance_estimate_m(const EllipsoidShape& shape, const Eigen::Vector3d& x_m) noexcept;
[[nodiscard]] double distance_estimate_m(const SuperquadricShape& shape, const Eigen::Vector3d& x_m) noexcept;

}  // namespace thenar
