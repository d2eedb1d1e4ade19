// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A solid's surface as triangles, counter-clockwise from outside.
struct TriangleMesh {
  Eigen::Matrix3Xd vertices_m;
  Eigen::Matrix3Xi triangles;  ///< Indices of vertices.
};

}  // namespace thenar
