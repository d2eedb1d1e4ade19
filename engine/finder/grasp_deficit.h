#pragma once

#include <Eigen/Core>

#include "solvers/grasp_forces.h"

namespace thenar {

/// Why a grasp is infeasible: the smallest forces that would have to act beside those the cones allow.
struct GraspDeficit {
  /// Per contact, in its frame (n, t1, t2) [N]: e of min |e|, G (f + e) = W^d, f inside the cones. What no forces at
  /// the contacts can give, such as a torque about the line through all of them, is left out.
  Eigen::Matrix<double, 3, kMaxGraspContacts> missing_N = Eigen::Matrix<double, 3, kMaxGraspContacts>::Zero();
  /// Least mu_c (to 1e-3), the same for all contacts, for which the wrench can be had with some squeeze; infinity if
  /// none up to 10.
  double least_friction = 0.0;
};

/// Explains an infeasible problem in forces. For messages and tests, not for a loop.
[[nodiscard]] GraspDeficit explain_infeasible_grasp(const GraspProblem& problem);

}  // namespace thenar
