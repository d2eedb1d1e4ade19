// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "thenar/eigen_layout.h"

namespace thenar {

/// The cells of n directions: the parts of the unit sphere nearest to each of them.
struct VoronoiCells {
  Eigen::VectorXd areas;       ///< [sr]; together 4 pi.
  Eigen::Matrix3Xd centroids;  ///< 3 x n, unit.
};

/// Computes the cells of n directions (3 x n, unit). Areas are within 1 % for a hundred even directions or more.
/// Directions that coincide have the same cell. Cost O(n^2).
[[nodiscard]] VoronoiCells voronoi_cells(const Eigen::Matrix3Xd& directions);

}  // namespace thenar
