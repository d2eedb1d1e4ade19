// SPDX-License-Identifier: Apache-2.0
#include "collision/point_grid.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::Vector3i;

PointGrid::PointGrid(const Eigen::Matrix3Xd& points_m, double radius_m) : points_m_(points_m), radius_m_(radius_m) {
  // From the 1 % to the 99 % point of each axis: a stray point must not make the cells wide.
  Vector3d extent_m;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd x_m = points_m.row(axis);
    const Index few = x_m.size() / 100;
    std::nth_element(x_m.begin(), x_m.begin() + few, x_m.end());
    low_m_[axis] = x_m[few];
    std::nth_element(x_m.begin(), x_m.end() - 1 - few, x_m.end());
    extent_m[axis] = x_m[x_m.size() - 1 - few] - low_m_[axis];
  }
  // 128 cells an axis bound the memory (2 M cells); denser clouds have fuller cells.
  cell_m_ = std::max(radius_m, extent_m.maxCoeff() / 128.0);
  cells_ = (extent_m / cell_m_).cast<int>() + Vector3i::Ones();

  // Counting sort: cell k holds members_[begin_[k] .. begin_[k + 1]).
  begin_.assign(cells_.cast<std::size_t>().prod() + 1, 0);
  for (Index i = 0; i < points_m.cols(); ++i) ++begin_[cell_of(points_m.col(i)) + 1];
  for (std::size_t k = 1; k < begin_.size(); ++k) begin_[k] += begin_[k - 1];
  members_.resize(points_m.cols());
  std::vector<Index> next(begin_.begin(), begin_.end() - 1);
  for (Index i = 0; i < points_m.cols(); ++i) members_[next[cell_of(points_m.col(i))]++] = i;
}

Index PointGrid::cell_of(const Vector3d& p_m) const {
  const Vector3i at = cell_at(p_m);
  return number(at.x(), at.y(), at.z());
}

}  // namespace thenar
