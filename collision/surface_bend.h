// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "thenar/eigen_layout.h"

namespace thenar {

/// The curvature of a surface around a point with the outward normal n. Over the plane across n its height is
///     w(u) = -(k_1 u_1^2 + k_2 u_2^2) / 2,   u along t_1 and t_2 = n x t_1.
struct SurfaceBend {
  Eigen::Vector3d t1 = Eigen::Vector3d::Zero();  ///< A principal direction, unit, across n.
  double k1_per_m = 0.0, k2_per_m = 0.0;         ///< Principal curvatures; > 0 where the solid is convex.

  [[nodiscard]] double most_per_m() const { return std::max(std::abs(k1_per_m), std::abs(k2_per_m)); }
};

/// The curvature of a sampled surface around a point p with the normal n, fitted to the normals and heights of the
/// samples around it by least squares. Exact on planes, and on balls but for rounding.
class BendFit {
 public:
  /// Begins a fit, in which samples beyond `support_m` do not count.
  BendFit(const Eigen::Vector3d& p_m, const Eigen::Vector3d& n, double support_m);

  /// Adds a sample of the same face (its normal differs by less than 60 degrees), other than p.
  void add(const Eigen::Vector3d& p_m, const Eigen::Vector3d& n);

  /// Returns the fit, the larger curvature first; flat if there are too few samples.
  [[nodiscard]] SurfaceBend bend() const;

 private:
  Eigen::Vector3d p_m_, n_, t1_, t2_;
  double support_m_;
  Eigen::Matrix3d A_ = Eigen::Matrix3d::Zero();  // Normal equations of k_11, k_12, k_22.
  Eigen::Vector3d b_ = Eigen::Vector3d::Zero();
};

}  // namespace thenar
