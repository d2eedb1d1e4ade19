// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "solvers/muscles/stiff_problem.h"

namespace thenar {

/// Computes the stiffness of the object, K_o(f) with the internal force s = `squeeze`. Returns false, and NaN, where a
/// posture is unstable: some D_k + M_k is not positive definite.
bool object_stiffness(const StiffMuscleProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& f, double squeeze,
                      Matrix6d& K_o) noexcept;

/// Returns D_k + M_k(f) with the internal force s = `squeeze`.
[[nodiscard]] FingerMatrix finger_stiffness(const StiffMuscleProblem& problem, int finger,
                                            const Eigen::Ref<const Eigen::VectorXd>& f, double squeeze) noexcept;

/// Computes the KKT error of forces, internal force and multipliers [no unit]: the largest of |f - clamp(..)| and the
/// torque errors as forces, relative to the largest force; the lack of K_o and the postures, relative to K_des and
/// kappa; the negative parts of Z and Y, and their products with the slacks, relative to the effort.
[[nodiscard]] double stiff_kkt_error(const StiffMuscleProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& f,
                                     const StiffMuscleReport& report) noexcept;

/// Computes the error of weights as a proof of infeasibility. Summed with them, H f = tau, the postures' limits and
///     v'(A - K_des) v - 2 sum_k v'B_k z_k + sum_k z_k'(D_k + M_k) z_k >= 0,
/// which K_o >= K_des means for any v and z_k, say sum_j h_j(f_j) >= need with concave h_j. The gap is the left side's
/// largest value within the limits, over the need. A gap below 1 is a proof.
[[nodiscard]] double stiff_infeasibility_gap(const StiffMuscleProblem& problem,
                                             const StiffMuscleReport& report) noexcept;

/// The stiffness that is lacking, from a proof that there are no forces.
struct StiffLack {
  /// The main direction of Z, of length 1 on length_m: translation, then rotation times length_m.
  Eigen::Matrix<double, 6, 1> direction = Eigen::Matrix<double, 6, 1>::Zero();
  double lacking_N_per_m = 0.0;  ///< K_des less this times diag(1, 1, 1, length_m^2, ..) is infeasible, too.
  int finger = -1;               ///< The unstable finger, if its posture is the cause.
  Eigen::Matrix<double, kMaxStiffJoints, 1> bend =
      Eigen::Matrix<double, kMaxStiffJoints, 1>::Zero();  ///< Its unstable direction, of length 1.
  double lacking_Nm_per_rad = 0.0;                        ///< kappa less this is infeasible, too.
  std::uint64_t at_limit = 0;                             ///< Muscles that the proof has at their limits, one bit each.
};

[[nodiscard]] StiffLack stiff_lack(const StiffMuscleProblem& problem, const StiffMuscleReport& report) noexcept;

}  // namespace thenar
