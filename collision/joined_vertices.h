// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// Finds vertices in one place: returns for each the least number of those that it is joined with. Two are joined if
/// they are no further apart than `apart_m`, and some that are up to 3.5 times as far; what is joined with a third one
/// is joined. With 0, or coordinates too large for the grid, vertices are joined that coincide. They are finite.
/// Cost O(n log n).
[[nodiscard]] std::vector<int> join_vertices(const Eigen::Matrix3Xd& vertices_m, double apart_m);

}  // namespace thenar
