#pragma once

#include <Eigen/Core>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

/// A place of a surface without samples.
struct CloudHole {
  Eigen::Vector3d centre_m;  ///< Of the largest empty ball in it.
  double radius_m;           ///< Of that ball: no point of the hole is farther from a sample. At most `largest_m`.
};

/// The holes of a closed surface that are wider than the support, largest first. Narrower gaps are how samples happen
/// to lie: in random samples a disc of that radius is empty with a probability of exp(-15).
///
/// A sample lies at a hole if a ball that touches it, centred in its tangent plane on the side away from its
/// neighbours, is empty and larger than the support. Neighbours beyond an edge are turned into the plane first, so
/// edges are no holes. `support_m` > 0 is that of the surface to be made; `largest_m` >= it is where the search ends.
/// Requires a repaired cloud; what fewer than three samples see is the air around an outlier. For work done once.
[[nodiscard]] std::vector<CloudHole> find_holes(const PointCloud& cloud, double support_m, double largest_m);

}  // namespace thenar
