#pragma once

#include <Eigen/Core>

namespace thenar {

/// The shares of the unit sphere nearest to each of n directions (3 x n, unit): the areas of their Voronoi cells [sr],
/// which sum to 4 pi. Within 1 % for a hundred even directions or more. Directions that coincide have the same cell.
/// Cost O(n^2).
[[nodiscard]] Eigen::VectorXd voronoi_areas(const Eigen::Matrix3Xd& directions);

}  // namespace thenar
