// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A surface as an unstructured set of samples with outward normals, in the body's frame.
struct PointCloud {
  Eigen::Matrix3Xd points_m;  ///< 3 x N.
  Eigen::Matrix3Xd normals;   ///< 3 x N, unit, outward; 3 x 0 for a scan without normals, until they are estimated.
};

/// Estimates the side of the square that a sample represents: the median over a subset, from eight neighbours each.
/// Throws std::invalid_argument for fewer than two samples. Cost O(points).
[[nodiscard]] double sample_spacing_m(const PointCloud& cloud);

}  // namespace thenar
