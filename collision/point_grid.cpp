#include "collision/point_grid.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::Vector3i;

PointGrid::PointGrid(const Eigen::Matrix3Xd& points_m, double radius_m) : points_m_(points_m), radius_m_(radius_m) {
  low_m_ = points_m.rowwise().minCoeff();
  const Vector3d extent_m = points_m.rowwise().maxCoeff() - low_m_;
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
  const Vector3i at = ((p_m - low_m_) / cell_m_).cast<int>();
  return number(at.x(), at.y(), at.z());
}

}  // namespace thenar
