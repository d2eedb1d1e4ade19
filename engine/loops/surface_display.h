// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/grasp/pulp.h"

namespace thenar {

/// The display of a pulp's deformation at every sample of its surface: the displacement of a sample is a weighted mean
/// of those of its ten nearest control points [27], with Gaussian weights of one control spacing that sum to 1. In
/// single precision: for display, not for physics.
///
/// Method: neighbouring samples share most of their control points. Each eight in the tree's order are a small dense
/// product with all control points that one of them needs.
class SurfaceDisplay {
 public:
  explicit SurfaceDisplay(const Pulp& pulp);

  /// Computes the displacement of every sample [m], distal frame: samples x 3, leaf after leaf: row i is that of sample
  /// pulp.order[i]. It is overwritten by the next call.
  /// `u_m` is the state's deformation, control points x 3; the surface moves by -u.
  /// Does not allocate.
  Eigen::Ref<const Eigen::MatrixX3f> displace(const Eigen::MatrixX3d& u_m);

 private:
  static constexpr Eigen::Index kNeighbours = 10;
  static constexpr int kLanes = 8;
  using Lanes = Eigen::Array<float, kLanes, 1>;

  void add_block(const Eigen::Matrix<int, kNeighbours, kLanes>& control,
                 const Eigen::Matrix<float, kNeighbours, kLanes>& weight);

  Eigen::Index samples_;
  // For each block in sequence: its control points, and their weights at the block's samples.
  std::vector<int> control_;
  std::vector<Lanes> weight_;
  std::vector<std::size_t> begin_;  ///< Begins of the blocks, and the end.
  Eigen::Matrix3Xf control_displacement_;
  Eigen::MatrixX3f displacement_;  ///< Whole blocks.
};

}  // namespace thenar
