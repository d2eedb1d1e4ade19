// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/surface_display.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace thenar {

using Eigen::Index;

SurfaceDisplay::SurfaceDisplay(const Pulp& pulp)
    : samples_(pulp.surface.points_m.cols()), control_displacement_(Eigen::Matrix3Xf::Zero(3, pulp.controls())) {
  const Index neighbours = std::min(kNeighbours, pulp.controls());
  const double spacing2 = pulp.area_m2.mean();
  std::vector<int> nearest(pulp.controls());
  begin_.push_back(0);
  for (Index first = 0; first < samples_; first += kLanes) {
    Eigen::Matrix<int, kNeighbours, kLanes> control = Eigen::Matrix<int, kNeighbours, kLanes>::Zero();
    Eigen::Matrix<float, kNeighbours, kLanes> weight = Eigen::Matrix<float, kNeighbours, kLanes>::Zero();
    for (Index lane = 0; lane < std::min<Index>(kLanes, samples_ - first); ++lane) {
      const Eigen::Vector3d point_m = pulp.surface.points_m.col(pulp.order[first + lane]);
      const Eigen::VectorXd d2 = (pulp.control_points_m.colwise() - point_m).colwise().squaredNorm().transpose();
      std::iota(nearest.begin(), nearest.end(), 0);
      std::partial_sort(nearest.begin(), nearest.begin() + neighbours, nearest.end(),
                        [&](int a, int b) { return d2[a] != d2[b] ? d2[a] < d2[b] : a < b; });
      Eigen::Array<double, kNeighbours, 1> w = Eigen::Array<double, kNeighbours, 1>::Zero();
      for (Index e = 0; e < neighbours; ++e) {
        control(e, lane) = nearest[e];
        w[e] = std::exp(-(d2[nearest[e]] - d2[nearest[0]]) / (2.0 * spacing2));
      }
      weight.col(lane) = (w / w.sum()).cast<float>();
    }
    add_block(control, weight);
  }
  displacement_.setZero(kLanes * (std::ssize(begin_) - 1), 3);
}

void SurfaceDisplay::add_block(const Eigen::Matrix<int, kNeighbours, kLanes>& control,
                               const Eigen::Matrix<float, kNeighbours, kLanes>& weight) {
  const auto begin = static_cast<std::ptrdiff_t>(begin_.back());
  for (int lane = 0; lane < kLanes; ++lane) {
    for (Index e = 0; e < kNeighbours; ++e) {
      if (weight(e, lane) <= 0.0F) continue;
      const auto known = std::find(control_.begin() + begin, control_.end(), control(e, lane)) - control_.begin();
      if (known == std::ssize(control_)) {
        control_.push_back(control(e, lane));
        weight_.emplace_back(Lanes::Zero());
      }
      weight_[known][lane] = weight(e, lane);
    }
  }
  begin_.push_back(control_.size());
}

Eigen::Ref<const Eigen::MatrixX3f> SurfaceDisplay::displace(const Eigen::MatrixX3d& u_m) {
  control_displacement_ = -u_m.transpose().cast<float>();
  for (std::size_t block = 0; block + 1 < begin_.size(); ++block) {
    Lanes x = Lanes::Zero(), y = x, z = x;
    for (std::size_t e = begin_[block]; e < begin_[block + 1]; ++e) {
      const auto d = control_displacement_.col(control_[e]);
      x += weight_[e] * d.x();
      y += weight_[e] * d.y();
      z += weight_[e] * d.z();
    }
    const auto first = kLanes * static_cast<Index>(block);
    displacement_.col(0).segment<kLanes>(first) = x.matrix();
    displacement_.col(1).segment<kLanes>(first) = y.matrix();
    displacement_.col(2).segment<kLanes>(first) = z.matrix();
  }
  return displacement_.topRows(samples_);
}

}  // namespace thenar
