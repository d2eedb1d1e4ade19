#pragma once

#include <Eigen/Core>

#include "engine/delassus.h"
#include "engine/frame.h"
#include "engine/model.h"
#include "engine/state.h"

namespace thenar {

/// Computes the compliance C_ij = softness k_ij S E_i' E_j S among the contacts that the frame holds.
void fill_compliance(const Model& model, Frame& frame);

/// u = rho u + (1 - rho) C f of finger k, at all its control points. `f` holds the frame's contact forces, rows (n, t1,
/// t2) each; `kernel_sum` is memory to work in, control points x 3. Does not allocate.
void deform(const Model& model, const Frame& frame, const ContactKinematics& now, int k, const Eigen::VectorXd& f,
            Eigen::MatrixX3d& kernel_sum, State& state);

}  // namespace thenar
