#pragma once

#include <Eigen/Core>

#include "engine/pulp.h"

namespace thenar {

/// Shows a pulp's deformation at every sample of its surface: the displacement of sample i is a weighted mean of those
/// of its nearest control points [27], with Gaussian weights of one control spacing that sum to 1.
class SurfaceDisplay {
 public:
  explicit SurfaceDisplay(const Pulp& pulp);

  /// Displacement of every sample [m], distal frame: 3 x samples in the first three rows.
  /// `u_m` is the state's deformation, control points x 3; the surface moves by -u.
  /// Does not allocate.
  const Eigen::Matrix4Xd& displace(const Eigen::MatrixX3d& u_m);

 private:
  static constexpr Eigen::Index kNeighbours = 10;

  Eigen::Matrix<int, kNeighbours, Eigen::Dynamic> control_;    ///< Control points of each sample.
  Eigen::Matrix<double, kNeighbours, Eigen::Dynamic> weight_;  ///< Columns sum to 1.
  Eigen::Matrix4Xd control_displacement_, displacement_;       ///< A fourth row fills the vector register.
};

}  // namespace thenar
