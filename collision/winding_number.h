// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collision/triangles.h"

namespace thenar {

/// The winding number of triangles around a point [Jacobson, Kavan, Sorkine-Hornung 2013]: their solid angle, seen from
/// it, over 4 pi. Of closed surfaces it is the number of solids that the point is in; of open ones it varies smoothly
/// between. Triangles that are far away count by their sum's dipole and its first moment [Barill et al. 2018]: the
/// error is some hundredths. Cost of a point O(log triangles), if it lies near few of them.
class WindingNumber {
 public:
  explicit WindingNumber(const TriangleMesh& mesh);
  [[nodiscard]] double operator()(const Eigen::Vector3d& point_m) const;

 private:
  /// Triangles [begin, end) of the order.
  struct Node {
    Eigen::Index begin = 0, end = 0;
    int first_child = 0;  ///< The second one follows it; 0 for a leaf.
    double radius_m = 0.0;
    Eigen::Vector3d middle_m = Eigen::Vector3d::Zero(), area_m2 = Eigen::Vector3d::Zero();
    Eigen::Matrix3d moment_m3 = Eigen::Matrix3d::Zero();
  };
  void split(const Eigen::Matrix3Xd& middles_m);
  void measure(Node& node) const;

  std::vector<Eigen::Index> order_;
  Eigen::Matrix3Xd corners_m_;  ///< Three of each triangle, in that order.
  std::vector<Node> nodes_;
};

}  // namespace thenar
