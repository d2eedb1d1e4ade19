// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

/// A region of a surface without samples.
struct CloudHole {
  Eigen::Vector3d centre_m;  ///< Centre of the largest empty ball in it.
  double radius_m;  ///< Radius of that ball, at most `largest_m`: no point of the hole is farther from a sample.
};

/// Finds the holes of a closed surface that are wider than the support, largest first. Narrower gaps occur by chance:
/// in random samples a disc of that radius is empty with a probability of exp(-15).
///
/// A sample lies at a hole if a ball that touches it, centred in its tangent plane on the side away from its
/// neighbours, is empty and larger than the support. Neighbours beyond an edge are first rotated into the plane, so
/// edges are no holes. `support_m` > 0 is that of the surface to be made; `largest_m` >= it limits the search. Requires
/// a repaired cloud; holes seen by fewer than three samples are the air around an outlier. For use outside of loops.
[[nodiscard]] std::vector<CloudHole> find_holes(const PointCloud& cloud, double support_m, double largest_m);

}  // namespace thenar
