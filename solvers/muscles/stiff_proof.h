#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "solvers/muscles/stiff_problem.h"

namespace thenar {

/// The stiffness of the object, K_o(f) with the squeeze s. False, and not a number, where a posture gives way: some
/// D_k + M_k is not positive definite.
bool object_stiffness(const StiffMuscleProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& f, double squeeze,
                      Matrix6d& K_o) noexcept;

/// D_k + M_k(f) with the squeeze s.
[[nodiscard]] FingerMatrix finger_stiffness(const StiffMuscleProblem& problem, int finger,
                                            const Eigen::Ref<const Eigen::VectorXd>& f, double squeeze) noexcept;

/// How far forces, squeeze and multipliers are from the optimum [no unit], the largest of: |f - clamp(..)| and the
/// forces that the torques' errors would be, as a share of the largest force; what K_o and the postures lack, as a
/// share of K_des and kappa; what Z and Y lack to be positive, and their products with the slacks, of the effort.
[[nodiscard]] double stiff_kkt_error(const StiffMuscleProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& f,
                                     const StiffMuscleReport& report) noexcept;

/// How far weights are from a proof that there are no forces. Summed with them, H f = tau, the postures' limits and
///     v'(A - K_des) v - 2 sum_k v'B_k z_k + sum_k z_k'(D_k + M_k) z_k >= 0,
/// which K_o >= K_des means for any v and z_k, say sum_j h_j(f_j) >= need with concave h_j. The gap is the most that
/// the left side can be within the limits, over the need. Below 1 it is a proof.
[[nodiscard]] double stiff_infeasibility_gap(const StiffMuscleProblem& problem,
                                             const StiffMuscleReport& report) noexcept;

/// What a proof that there are no forces says in words.
struct StiffLack {
  /// The main direction of Z, of length 1 on length_m: translation, then rotation times length_m.
  Eigen::Matrix<double, 6, 1> direction = Eigen::Matrix<double, 6, 1>::Zero();
  double lacking_N_per_m = 0.0;  ///< K_des less this times diag(1, 1, 1, length_m^2, ..) cannot be had either.
  int finger = -1;               ///< The one that gives way, if its posture is the cause.
  Eigen::Matrix<double, kMaxStiffJoints, 1> bend =
      Eigen::Matrix<double, kMaxStiffJoints, 1>::Zero();  ///< How it does, of length 1.
  double lacking_Nm_per_rad = 0.0;                        ///< kappa less this cannot be had either.
  std::uint64_t at_limit = 0;                             ///< The muscles that it takes at their limits, a bit each.
};

[[nodiscard]] StiffLack stiff_lack(const StiffMuscleProblem& problem, const StiffMuscleReport& report) noexcept;

}  // namespace thenar
