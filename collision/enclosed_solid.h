// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collision/triangles.h"

namespace thenar {

/// The union of the solids that a mesh encloses, equally dense.
struct EnclosedSolid {
  double volume_m3 = 0.0;  ///< Not above 0: it encloses none.
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  double error_m = 0.0;  ///< How far the centroid may be off for holes: were each closed by half a ball, not flat.
};

/// Measures what a mended mesh encloses. Holes are closed by triangles to the middle of their rims. By Gauss, of the
/// tetrahedra from a point to all triangles: exact, if no two solids overlap. What lies in several solids counts once:
/// it is measured along some hundred thousand lines, to some thousandths of it. Cost O(n log n).
[[nodiscard]] EnclosedSolid enclosed_solid(const TriangleMesh& mesh);

}  // namespace thenar
