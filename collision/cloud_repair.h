#pragma once

#include <Eigen/Core>

#include "collision/point_cloud.h"

namespace thenar {

/// What repair() did to a cloud.
struct CloudRepair {
  Eigen::Index turned = 0;      ///< Samples whose normals were outvoted by the samples in their tangent plane.
  Eigen::Index removed = 0;     ///< Samples whose neighbours' votes were divided.
  double doubtful_share = 0.0;  ///< Both, as a share of all samples.
};

/// Makes a cloud consistent before a surface is made of it. A sample whose normal is outvoted by the samples in its
/// tangent plane is turned; one with a divided vote is removed. The others keep their order.
/// `support_m` > 0 is the support of the surface to be made (2.2 spacings). For work done once.
CloudRepair repair(PointCloud& cloud, double support_m);

}  // namespace thenar
