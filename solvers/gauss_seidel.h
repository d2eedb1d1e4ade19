#pragma once

#include <Eigen/Core>
#include <limits>

#include "thenar/eigen_layout.h"

namespace thenar {

/// When a contact solve stops.
struct GaussSeidelSettings {
  double tolerance = 1e-6;  ///< Stop at this natural-map residual [no unit]; see residual.h.
  int max_sweeps = 200;     ///< Bounds the time of one call.
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

/// What one contact solve returns by value.
struct SolveReport {
  SolveStatus status = SolveStatus::kConverged;
  int sweeps = 0;
  double residual = 0.0;        ///< Natural map, 2-norm [no unit]; see residual.h.
  double residual_worst = 0.0;  ///< Of the worst single contact, over the same scale.
};

/// Of a problem that is not one: forces and gaps are zero, and no number may pass for a good one.
[[nodiscard]] inline SolveReport not_finite(int sweeps) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {SolveStatus::kNotFinite, sweeps, kInfinity, kInfinity};
}

struct SweepWorkspace;  // contact_sweeps.h

/// Finds the contact forces f of n points with Coulomb friction in a frozen contact space.
///
/// With the gaps delta = W f + delta_free, every point satisfies
///     0 <= f_n  _|_  delta_n >= 0                       Signorini, eq. (24) of the paper
///     f_t minimises f_t.delta_t over |f_t| <= mu f_n    Coulomb, eq. (29)
/// Method: nonlinear Gauss-Seidel with the one-step local update [Duriez et al. 2004]; delta is kept up to date by
/// increments, and a contact whose force did not change costs nothing.
///
/// Shapes    W 3n x 3n; delta_free, f, delta 3n; mu n. Point i owns rows 3i..3i+2 = normal, tangent 1, tangent 2.
///           Looked at for kNotFinite are the diagonals and first columns of the blocks W_ii. A NaN elsewhere is seen
///           only where its column's contact has a force.
/// Units     W m/N; delta_free, delta m; f N.
/// Requires  W symmetric, positive semi-definite, mu >= 0. A row of zeros is a contact that no force moves: open, or
///           without solution if its gap is below -touching_m (residual.h), which is told where the others' forces are
///           found. Symmetry to a few digits will do, for W's columns alone are read.
/// f         In: first guess, usually the last step's forces. Out: finite and inside every cone, also when the budget
///           is spent.
/// delta     Out: W f + delta_free.
/// residual  Of the forces and gaps returned. Without contacts or free motion: f = 0, converged.
/// Cost      9n^2 multiply-adds a sweep. Does not allocate, lock or throw.
///
/// It need not converge: it stalls on opposed walls, interference fits and viscosity ratios of 1e3 and more. The
/// residual tells.
[[nodiscard]] SolveReport solve_contacts(const Eigen::Ref<const Eigen::MatrixXd>& W,
                                         const Eigen::Ref<const Eigen::VectorXd>& delta_free,
                                         const Eigen::Ref<const Eigen::VectorXd>& mu,
                                         const GaussSeidelSettings& settings, Eigen::Ref<Eigen::VectorXd> f,
                                         Eigen::Ref<Eigen::VectorXd> delta) noexcept;

/// The same with a workspace, 1.3 (15 contacts) to 2.5 times (60) as fast, and it stalls less often: sweeps in single
/// precision, each accelerated, on gaps that are computed in double precision often enough; see contact_sweeps.h. What
/// it returns is as accurate.
///
/// W         Outside of 1e-20 .. 1e20 m/N it takes the plain sweeps, as where the largest |delta_free| [m], the
///           residual's scale [N] (see residual.h) is outside of 1e-15 .. 1e15 or the first guess beyond 1e15 N.
[[nodiscard]] SolveReport solve_contacts(const Eigen::Ref<const Eigen::MatrixXd>& W,
                                         const Eigen::Ref<const Eigen::VectorXd>& delta_free,
                                         const Eigen::Ref<const Eigen::VectorXd>& mu,
                                         const GaussSeidelSettings& settings, SweepWorkspace& work,
                                         Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<Eigen::VectorXd> delta) noexcept;

}  // namespace thenar
