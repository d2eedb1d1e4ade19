#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/delassus.h"
#include "engine/frame.h"
#include "engine/model.h"
#include "engine/state.h"

namespace thenar {

/// Computes the compliance C_ij = softness k_ij S E_i' E_j S among the contacts that the frame holds, of the pulps and of a soft
/// object.
void fill_compliance(const Model& model, Frame& frame);

/// What deform works in: the loads T_j f_j of one finger, distal frame, and the sums of k_ij T_j f_j at its control points.
struct PulpLoads {
  struct Load {
    Eigen::Index control_point;
    Eigen::Vector3d w;
  };
  explicit PulpLoads(const Model& model);

  std::vector<Load> loads;
  Eigen::MatrixX3d kernel_sum;  ///< Control points x 3.
};

/// u = rho u + (1 - rho) C f of finger k, at all its control points. `f` holds the frame's contact forces, rows (n, t1,
/// t2) each. Does not allocate.
void deform(const Model& model, const Frame& frame, const ContactKinematics& now, int k, const Eigen::VectorXd& f,
            PulpLoads& work, State& state);

}  // namespace thenar
