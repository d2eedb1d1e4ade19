// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "solvers/muscles/stiff_proof.h"

namespace thenar {

/// An optimum, or a difference of optima.
struct StiffOptimum {
  Eigen::Matrix<double, kMaxMuscles + 1, 1> x;  ///< Forces, then s times the root of its weight.
  Eigen::Matrix<double, kMaxJoints, 1> l;
  Matrix6d Z;  ///< Scaled by `length_m`.
  std::array<FingerMatrix, kMaxStiffFingers> Y;
};

/// Warm start: the result of a solve for the next one of a similar problem; of fixed size.
struct StiffWarmStart {
  bool is_set = false;
  Eigen::Index variables = 0, joints = 0, fingers = 0;
  StiffOptimum at;    ///< The last optimum.
  StiffOptimum way;   ///< Change to it from the optimum before.
  StiffOptimum bend;  ///< Change of `way` from the one before.
  /// Order of extrapolation that would have been nearest to the last optimum: 0 constant, 1 linear, 2 quadratic.
  int order = 0;
  Matrix6d basis;  ///< Rows: approximate eigenvectors of K_o - K_des, scaled by `length_m`.
};

/// Finds the forces by Newton's method on the conditions of an optimum, for which semidefinite matrices are projections
/// of Z - c (K_o - K_des) and bounds of H'l + ..: from the last optimum or an extrapolation of the last ones, if there
/// is one; else from the optimum between planes tangent to the limits of stiffness, which a dual active set adds as
/// they are violated. Where no stiffness is required the forces are those of solve_muscle_forces.
///
/// problem   At most kMaxJoints x kMaxMuscles; A, D, K_des, D_1, A_1 symmetric.
/// last      In: the last optimum. Out: the new one, if found.
/// f         Out, muscles [N]: the optimum; on failure unchanged.
/// Cost      Does not allocate or throw; the same problem (and start) gives the same bits.
[[nodiscard]] StiffMuscleReport solve_stiff_muscles(const StiffMuscleProblem& problem,
                                                    Eigen::Ref<Eigen::VectorXd> f) noexcept;
[[nodiscard]] StiffMuscleReport solve_stiff_muscles(const StiffMuscleProblem& problem, StiffWarmStart& last,
                                                    Eigen::Ref<Eigen::VectorXd> f) noexcept;

/// Finds the stiffness that an infeasible problem lacks: K_des, or kappa if postures are the cause, is lowered by
/// bisection until it is feasible. The lack is proved, and tight to a thousandth. For messages: some forty solves. A
/// lack of torque is not determined.
[[nodiscard]] StiffLack find_stiff_lack(const StiffMuscleProblem& problem) noexcept;

}  // namespace thenar
