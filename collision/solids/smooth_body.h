// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collision/shapes.h"
#include "collision/solids/surface_form.h"

namespace thenar {

// Nearest points on ellipsoids and superquadrics. A superquadric with an exponent above 1 has creases where it meets a
// plane of symmetry: the curvature across them is infinite, and with an exponent of 2 they are edges. On a crease, seen
// from outside, the normal is along x - point.
//
// x and near are finite, and no longer than 1e9 m. No function allocates, throws or returns NaN.

/// Finds the foot of x by Newton's method from `near_m`: a local minimum of distance. Outside, and from a start on the
/// side of x, it is the nearest point.
///
/// Accuracy  1e-12 of the size of an ellipsoid; on superquadrics 1e-9 m. Creases of exponents from 1.9 to 2 are nearly
///           edges, where the method converges slowly: nearest_on() is then some um off in some of 1e5 cases, and a
///           foot, found from one start alone, in some of 1e4.
[[nodiscard]] SurfaceForm foot_on(const EllipsoidShape& shape, const Eigen::Vector3d& x_m,
                                  const Eigen::Vector3d& near_m) noexcept;
[[nodiscard]] SurfaceForm foot_on(const SuperquadricShape& shape, const Eigen::Vector3d& x_m,
                                  const Eigen::Vector3d& near_m) noexcept;

/// Finds the point nearest to x. Inside a superquadric it is the foot found from `near_m`; without it the nearest of
/// those from starts all over the surface.
[[nodiscard]] SurfaceForm nearest_on(const EllipsoidShape& shape, const Eigen::Vector3d& x_m) noexcept;
[[nodiscard]] SurfaceForm nearest_on(const SuperquadricShape& shape, const Eigen::Vector3d& x_m,
                                     const std::optional<Eigen::Vector3d>& near_m) noexcept;

/// Estimates the distance of x from the surface to first order: exact on the surface.
[[nodiscard]] double distance_estimate_m(const EllipsoidShape& shape, const Eigen::Vector3d& x_m) noexcept;
[[nodiscard]] double distance_estimate_m(const SuperquadricShape& shape, const Eigen::Vector3d& x_m) noexcept;

}  // namespace thenar
