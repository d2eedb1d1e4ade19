#pragma once

#include <Eigen/Core>
#include <span>

#include "engine/finder/found_grasp.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// The measures of a grasp that do not ask how hard it presses: the convex hull of the wrenches that each edge of each
/// contact's cone gives with a normal force of 1 N, cones of eight edges inscribed in Coulomb's. Moments are about
/// `centre_m`, in units of the lever.
/// Cost      an incremental hull in six dimensions: some 10 ms for three contacts, 100 ms for five.
[[nodiscard]] GraspQuality grasp_quality(std::span<const GraspContact> contacts, const Eigen::Vector3d& centre_m,
                                         double friction, double lever_m);

/// The hull of points in six dimensions: the least distance of the origin from a facet (0 if the origin is outside),
/// and the volume.
struct Hull6 {
  double inradius = 0.0, volume = 0.0;
};
[[nodiscard]] Hull6 hull6(const Eigen::Matrix<double, 6, Eigen::Dynamic>& points);

}  // namespace thenar
