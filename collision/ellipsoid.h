// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "thenar/eigen_layout.h"

namespace thenar {

/// Finds the point of an ellipsoid nearest to x, in its axes; one of them if several are as near. Exact to rounding,
/// some 1e-15 of its size. Does not allocate or throw.
[[nodiscard]] Eigen::Vector3d nearest_on_ellipsoid(const Eigen::Vector3d& semi_axes_m,
                                                   const Eigen::Vector3d& x_m) noexcept;

}  // namespace thenar
