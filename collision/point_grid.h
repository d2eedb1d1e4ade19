// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// Points sorted into cubic cells no smaller than a radius: a point's neighbours lie in its 27 cells. For use when a
/// cloud is made or read. A view of the points.
class PointGrid {
 public:
  /// `points_m` is 3 x N, N >= 1, finite; radius > 0.
  PointGrid(const Eigen::Matrix3Xd& points_m, double radius_m);

  /// Calls visit(j, distance) for every other point j closer than the radius to point i.
  template <typename Visit>
  void for_each_neighbour(Eigen::Index i, Visit visit) const {
    const Eigen::Vector3d p = points_m_.col(i);
    const Eigen::Vector3i at = cell_at(p);
    const Eigen::Vector3i from = (at.array() - 1).max(0), to = (at.array() + 1).min(cells_.array() - 1);
    for (int x = from.x(); x <= to.x(); ++x) {
      for (int y = from.y(); y <= to.y(); ++y) {
        // Cells along z are adjacent in memory.
        const Eigen::Index end = begin_[number(x, y, to.z()) + 1];
        for (Eigen::Index m = begin_[number(x, y, from.z())]; m < end; ++m) {
          const Eigen::Index j = members_[m];
          const double squared = (points_m_.col(j) - p).squaredNorm();
          if (squared < radius_m_ * radius_m_ && j != i) visit(j, std::sqrt(squared));
        }
      }
    }
  }

  /// Returns the points, cell by cell.
  [[nodiscard]] const std::vector<Eigen::Index>& members() const { return members_; }

 private:
  [[nodiscard]] Eigen::Index number(int x, int y, int z) const {
    return (static_cast<Eigen::Index>(x) * cells_.y() + y) * cells_.z() + z;
  }
  /// Returns a point's cell. Points outside belong to the outermost cells: neighbours stay neighbours.
  [[nodiscard]] Eigen::Vector3i cell_at(const Eigen::Vector3d& p_m) const {
    const Eigen::Array3d last = (cells_.array() - 1).cast<double>();
    return ((p_m - low_m_) / cell_m_).array().max(0.0).min(last).cast<int>();
  }
  [[nodiscard]] Eigen::Index cell_of(const Eigen::Vector3d& p_m) const;

  const Eigen::Matrix3Xd& points_m_;
  double radius_m_, cell_m_;
  Eigen::Vector3d low_m_;
  Eigen::Vector3i cells_;
  std::vector<Eigen::Index> begin_, members_;
};

}  // namespace thenar
