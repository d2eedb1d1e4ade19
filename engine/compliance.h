#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/delassus.h"
#include "engine/frame.h"
#include "engine/model.h"
#include "engine/state.h"

namespace thenar {

/// Computes the kernels among the contacts that the frame holds, of the pulps and of a soft object. The compliance is
/// C_ij = k_ij B_i B_j' in the axes that the contacts have in a tick (ContactKinematics): pulps have B = S E_F'.
void fill_kernels(const Model& model, Frame& frame);

/// What deform works in: the loads w_j = B_j' f_j of one finger, distal frame, and the sums of k_ij w_j at its control
/// points.
struct PulpLoads {
  struct Load {
    Eigen::Index control_point;
    Eigen::Vector3d w;
  };
  explicit PulpLoads(const Model& model);

  std::vector<Load> loads;
  Eigen::MatrixX3d kernel_sum;  ///< Control points x 3.
};

/// u = rho u + (1 - rho) C f of finger k, at all its control points, with the C that the solver had. `f` holds the frame's contact forces, rows (n, t1,
/// t2) each. Does not allocate.
void deform(const Model& model, const Frame& frame, const ContactKinematics& now, int k, const Eigen::VectorXd& f,
            PulpLoads& work, State& state);

}  // namespace thenar
