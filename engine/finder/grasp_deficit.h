// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "solvers/grasp_forces.h"

namespace thenar {

/// The deficit of an infeasible grasp: the least forces needed besides those that the cones allow.
struct GraspDeficit {
  /// Per contact, in its frame (n, t1, t2) [N]: e of min |e|, G (f + e) = W^d, f inside the cones. Wrenches that no
  /// forces at the contacts can give, such as a torque about the line through all of them, are left out.
  Eigen::Matrix<double, 3, kMaxGraspContacts> missing_N = Eigen::Matrix<double, 3, kMaxGraspContacts>::Zero();
  /// Least mu_c (to 1e-3), the same for all contacts, that makes the wrench feasible with some internal force; infinity
  /// if none up to 10.
  double least_friction = 0.0;
};

/// Explains an infeasible problem in forces. For messages and tests, not for a loop.
[[nodiscard]] GraspDeficit explain_infeasible_grasp(const GraspProblem& problem);

}  // namespace thenar
