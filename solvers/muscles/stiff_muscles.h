#pragma once

#include <Eigen/Core>
#include <array>

#include "solvers/muscles/stiff_proof.h"

namespace thenar {

/// An optimum, or a difference of some.
struct StiffOptimum {
  Eigen::Matrix<double, kMaxMuscles + 1, 1> x;  ///< Forces, then the squeeze times the root of its weight.
  Eigen::Matrix<double, kMaxJoints, 1> l;
  Matrix6d Z;  ///< On `length_m`.
  std::array<FingerMatrix, kMaxStiffFingers> Y;
};

/// What a solve leaves to the next one of a like problem; of fixed size.
struct StiffWarmStart {
  bool is_set = false;
  Eigen::Index variables = 0, joints = 0, fingers = 0;
  StiffOptimum at;    ///< The last optimum,
  StiffOptimum way;   ///< the way to it from the one before,
  StiffOptimum bend;  ///< and how that differed from the way before.
  /// Which guess would have come nearest to the last optimum: 0 that it stays, 1 that its way goes on, 2 with its bend.
  int order = 0;
  Matrix6d basis;  ///< Rows: about the eigenvectors of K_o - K_des on `length_m`.
};

/// Finds the forces by Newton's method on the conditions of an optimum, for which semidefinite matrices are projections
/// of Z - c (K_o - K_des) and bounds of H'l + ..: from the last optimum, or where the way to it leads on, if there is
/// one; else from the optimum between planes that touch the limits of stiffness, which a dual active set takes up as
/// they are violated. Forces without need of stiffness are those of solve_muscle_forces.
///
/// problem   At most kMaxJoints x kMaxMuscles; A, D, K_des, D_1, A_1 symmetric.
/// last      In: the last optimum. Out: this one, if it is one.
/// f         Out, muscles [N]: the optimum; on failure left as it was.
/// Cost      Does not allocate or throw; the same problem (and start) gives the same bits.
[[nodiscard]] StiffMuscleReport solve_stiff_muscles(const StiffMuscleProblem& problem,
                                                    Eigen::Ref<Eigen::VectorXd> f) noexcept;
[[nodiscard]] StiffMuscleReport solve_stiff_muscles(const StiffMuscleProblem& problem, StiffWarmStart& last,
                                                    Eigen::Ref<Eigen::VectorXd> f) noexcept;

/// What an infeasible problem lacks, by the proof that says most: K_des, or if postures are the cause kappa, is lowered
/// by halves until it is feasible. The lack is proved, and a thousandth more than it is not lacking. For messages: some
/// forty solves. What torques lack is not told.
[[nodiscard]] StiffLack find_stiff_lack(const StiffMuscleProblem& problem) noexcept;

}  // namespace thenar
