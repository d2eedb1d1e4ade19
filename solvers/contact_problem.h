// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A contact problem: find the forces f of n points with Coulomb friction in a frozen contact space. With the gaps
/// delta = W f + delta_free, every point satisfies
///     0 <= f_n  _|_  delta_n >= 0                       Signorini, eq. (24) of the paper
///     f_t minimises f_t.delta_t over |f_t| <= mu f_n    Coulomb, eq. (29)
/// Point i owns rows 3i..3i+2 = normal, tangent 1, tangent 2. A view: the numbers are owned elsewhere.
///
/// Requires  W symmetric, positive semi-definite, mu >= 0. A row of zeros is a contact that no force moves: open, or
///           without solution if its gap is below -touching_m (residual.h).
struct ContactProblem {
  Eigen::Ref<const Eigen::MatrixXd> W;           ///< 3n x 3n [m/N].
  Eigen::Ref<const Eigen::VectorXd> delta_free;  ///< Gaps and slips without contact forces, 3n [m].
  Eigen::Ref<const Eigen::VectorXd> mu;          ///< n.
};

/// The output of a contact solver; a view.
struct ContactSolution {
  /// 3n [N]. In: first guess, usually the last step's forces. Out: finite and inside every cone, with any status.
  Eigen::Ref<Eigen::VectorXd> f;
  Eigen::Ref<Eigen::VectorXd> delta;  ///< Out: W f + delta_free, 3n [m].
};

/// A contact problem that owns its numbers.
struct ContactData {
  Eigen::MatrixXd W;
  Eigen::VectorXd delta_free, mu;

  [[nodiscard]] Eigen::Index contacts() const { return mu.size(); }
  operator ContactProblem() const { return {W, delta_free, mu}; }
};

enum class SolveStatus {
  kConverged,
  kBudgetSpent,  ///< The forces are inside their cones and usable; the residual says how good they are.
  /// Input not finite, W's diagonal or mu negative, the residual's scale infinite or below 1e-140 N without being zero,
  /// or forces that grew beyond all numbers, as they may with an indefinite W. Forces and gaps are zero, residuals
  /// infinite.
  kNotFinite,
  kNoSolution,  ///< No forces exist: normal forces that move nothing, W y = 0, press where gaps are closed in sum.
};

/// Result of one contact solve.
struct SolveReport {
  SolveStatus status = SolveStatus::kConverged;
  int sweeps = 0;
  double residual = 0.0;        ///< Natural map, 2-norm [no unit]; see residual.h.
  double residual_worst = 0.0;  ///< Residual of the worst single contact, on the same scale.
};

/// Returns the report of an invalid problem, whose residuals are infinite; sets forces and gaps to zero.
[[nodiscard]] inline SolveReport not_finite(int sweeps) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {SolveStatus::kNotFinite, sweeps, kInfinity, kInfinity};
}
[[nodiscard]] inline SolveReport not_finite(int sweeps, ContactSolution solution) {
  solution.f.setZero();
  solution.delta.setZero();
  return not_finite(sweeps);
}

}  // namespace thenar
