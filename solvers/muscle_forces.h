#pragma once

#include <Eigen/Core>

#include "solvers/lcp.h"

namespace thenar {

/// How a muscle-force problem ended.
enum class MuscleStatus {
  kOptimal,
  kInfeasible,   ///< No pulling forces give the torques.
  kBudgetSpent,  ///< No answer: the pivots ran out, or the input was not finite.
};

struct MuscleReport {
  MuscleStatus status = MuscleStatus::kBudgetSpent;
  int iterations = 0;
  double residual_Nm = 0.0;  ///< max |H f - tau|.
};

/// Memory of the muscle-force solves for up to `joints` x `muscles`; taken once.
class MuscleWorkspace {
 public:
  MuscleWorkspace(Eigen::Index joints, Eigen::Index muscles);

  LcpWorkspace lcp;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> Y;  ///< Orthonormal rows that span those of H.
  Eigen::VectorXd t;                                                         ///< Y f = t is H f = tau.
  Eigen::MatrixXd pi;
  Eigen::VectorXd least;  ///< H^+ tau, the least forces of either sign.
  Eigen::VectorXd z;
};

/// Finds the muscle forces of eq. (23),
///     min f'f,  H f = tau,  f >= 0,
/// by the same LCP as the grasp forces: with pi = I - H^+ H,  0 <= f = pi z + H^+ tau  _|_  z >= 0.
/// pi and H^+ come from orthonormal rows of H; a row that depends on the others is left out if its torque agrees with
/// theirs, else there are no such forces.
///
/// Shapes    H joints x muscles [m]; tau joints [N m]; f muscles [N].
/// f         Out: the optimum; on failure left as it was.
/// Cost      an LCP of one row a muscle. Does not allocate or throw.
[[nodiscard]] MuscleReport solve_muscle_forces(const Eigen::Ref<const Eigen::MatrixXd>& H,
                                               const Eigen::Ref<const Eigen::VectorXd>& tau, MuscleWorkspace& work,
                                               Eigen::Ref<Eigen::VectorXd> f) noexcept;

}  // namespace thenar
