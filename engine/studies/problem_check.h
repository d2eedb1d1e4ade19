#pragma once

#include <Eigen/Core>
#include <limits>

#include "solvers/grasp_forces.h"
#include "solvers/lcp.h"
#include "solvers/muscles/muscle_forces.h"
#include "solvers/residual.h"

namespace thenar {

// What an answer is worth, from the problem as its file holds it and from nothing that a solver reports. For grasp
// forces see grasp_kkt_error and infeasibility_gap.

/// A verdict that there is no solution counts as proved up to this gap: solutions a million times larger than the
/// problem's own size are none. In doubles no gap is smaller than the rounding of its certificate.
inline constexpr double kProvedGap = 1e-6;

/// Natural map of forces f, gaps computed anew. Infinite if a contact that no force moves is pressed: then no forces
/// are right.
[[nodiscard]] Residual contact_residual(const ContactProblem& problem, const Eigen::VectorXd& f);

/// What the last digits of a grasp's contact points and wrench can do to its forces, as a share of them: the rounding
/// of doubles times the condition of G about the contacts' centroid, arms over their size. What no contact forces can
/// give, such as a torque about the line through all contacts, does not count.
[[nodiscard]] double grasp_rounding(const GraspProblem& problem);

/// How far f is from the optimum of min 1/2 f'f, H f = tau, 0 <= f <= limit, as a share of |f|: the largest of
///     |H^+ (H f - tau)|            the least forces that would make up for the torques that are missing,
///     max(-f), max(f - limit)      pushing muscles, and those beyond their limits,
///     |f - H'l - s|                least over l and s (s >= 0 where f = 0, <= 0 at the limit, else 0): the rest.
[[nodiscard]] double muscle_residual(const MuscleProblem& problem, const Eigen::VectorXd& f);

/// max |min(w_i, m z_i)| with w = M z + q, over the largest terms that w can have, max |q| + m sum |z|; m = max |M|
/// brings z to the unit of w.
[[nodiscard]] double lcp_residual(const LcpProblem& problem, const Eigen::VectorXd& z);

/// What normal forces y >= 0, one a contact, prove about a contact problem. Where they move nothing, W y = 0,
/// and press where the free gaps are closed in sum, y.q < 0, there are no forces f: any would leave y.u_n = y.q < 0,
/// and so some gap below zero.
struct ContactVerdict {
  double closed_m = 0.0;  ///< -y.q: by how much the gaps are closed, in sum, weighted by y.
  /// Solutions are at least 1/gap times the residual's scale |rho q| large; 0: there are none.
  double gap = std::numeric_limits<double>::infinity();
};

[[nodiscard]] ContactVerdict contact_verdict(const ContactProblem& problem, const Eigen::VectorXd& y);

/// What no pulling forces give of the torques.
struct MuscleDeficit {
  Eigen::VectorXd missing_Nm;  ///< tau - H f of least norm over f >= 0.
  /// Solutions are at least 1/gap times as large as |H^+ tau|; 0: there are none.
  double gap = std::numeric_limits<double>::infinity();
};

/// Explains a problem that is infeasible, limits aside, and proves it: with r = missing, H'r <= 0 and tau.r > 0.
[[nodiscard]] MuscleDeficit explain_infeasible_muscles(const MuscleProblem& problem);

/// What y >= 0 leaves possible: a solution has |z| >= -y.q / |max(0, M'y)|, and this is max |q| / max |M| over that.
/// Zero proves that there is none; infinity if y.q >= 0.
[[nodiscard]] double lcp_infeasibility_gap(const LcpProblem& problem, const Eigen::VectorXd& y);

}  // namespace thenar
