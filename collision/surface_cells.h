// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>

#include "thenar/eigen_layout.h"

namespace thenar {

/// The cells of n points of a smooth convex surface: the parts of the surface nearest to each of them.
struct SurfaceCells {
  Eigen::VectorXd areas_m2;
  Eigen::Matrix3Xd centroids_m;  ///< 3 x n, each on the plane that touches at its point.
};

/// A function that returns the surface's nearest point to a given one.
using OntoSurface = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// Computes the cells of n points (3 x n) with outward normals (3 x n, unit) of a closed surface of the area
/// `whole_m2`, to which the areas add up; of eighty even points each is within 6 %, and 1.4 % in the mean square.
/// Without `onto` areas are those on the planes, for use of the centroids alone. Cost O(n^2).
[[nodiscard]] SurfaceCells surface_cells(const Eigen::Matrix3Xd& points_m, const Eigen::Matrix3Xd& normals,
                                         const OntoSurface& onto, double whole_m2);

}  // namespace thenar
