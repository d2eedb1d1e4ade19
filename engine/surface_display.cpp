#include "engine/surface_display.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace thenar {

using Eigen::Index;

SurfaceDisplay::SurfaceDisplay(const Pulp& pulp)
    : control_(kNeighbours, pulp.surface.points_m.cols()),
      weight_(kNeighbours, pulp.surface.points_m.cols()),
      control_displacement_(Eigen::Matrix4Xd::Zero(4, pulp.controls())),
      displacement_(Eigen::Matrix4Xd::Zero(4, pulp.surface.points_m.cols())) {
  const Index neighbours = std::min(kNeighbours, pulp.controls());
  const double spacing2 = pulp.area_m2.mean();
  std::vector<int> order(pulp.controls());
  control_.setZero();
  weight_.setZero();
  for (Index i = 0; i < control_.cols(); ++i) {
    const Eigen::VectorXd d2 =
        (pulp.control_points_m.colwise() - pulp.surface.points_m.col(i)).colwise().squaredNorm().transpose();
    std::iota(order.begin(), order.end(), 0);
    std::partial_sort(order.begin(), order.begin() + neighbours, order.end(),
                      [&](int a, int b) { return d2[a] != d2[b] ? d2[a] < d2[b] : a < b; });
    for (Index e = 0; e < neighbours; ++e) {
      control_(e, i) = order[e];
      weight_(e, i) = std::exp(-(d2[order[e]] - d2[order[0]]) / (2.0 * spacing2));
    }
    weight_.col(i) /= weight_.col(i).sum();
  }
}

const Eigen::Matrix4Xd& SurfaceDisplay::displace(const Eigen::MatrixX3d& u_m) {
  control_displacement_.topRows<3>() = -u_m.transpose();
  for (Index i = 0; i < control_.cols(); ++i) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (Index e = 0; e < kNeighbours; ++e) sum += weight_(e, i) * control_displacement_.col(control_(e, i));
    displacement_.col(i) = sum;
  }
  return displacement_;
}

}  // namespace thenar
