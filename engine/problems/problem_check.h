// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>

#include "solvers/grasp_forces.h"
#include "solvers/lcp.h"
#include "solvers/muscles/muscle_forces.h"
#include "solvers/residual.h"

namespace thenar {

// Errors of answers, from the problem in its file and not from a solver's report. For grasp forces see grasp_kkt_error
// and infeasibility_gap.

/// Largest gap of a proof that there is no solution: solutions a million times the problem's own size do not count. In
/// doubles no gap is smaller than the rounding of its certificate.
inline constexpr double kProvedGap = 1e-6;

/// Computes the natural map of forces f with recomputed gaps. Infinite if a contact that no force moves is closed: no
/// forces are correct then.
[[nodiscard]] Residual contact_residual(const ContactProblem& problem, const Eigen::VectorXd& f);

/// Returns the relative error of a grasp's forces by the rounding of its contact points and wrench: that of doubles
/// times the condition of G about the contacts' centroid, arms over their size. Wrenches that no contact forces can
/// give, such as a torque about the line through all contacts, do not count.
[[nodiscard]] double grasp_rounding(const GraspProblem& problem);

/// Computes the error of f as the optimum of min 1/2 f'f, H f = tau, 0 <= f <= limit, relative to |f|: the largest of
///     |H^+ (H f - tau)|            the least forces that would make up for the torques that are missing,
///     max(-f), max(f - limit)      pushing muscles, and those beyond their limits,
///     |f - H'l - s|                least over l and s (s >= 0 where f = 0, <= 0 at the limit, else 0): the rest.
[[nodiscard]] double muscle_residual(const MuscleProblem& problem, const Eigen::VectorXd& f);

/// Computes max |min(w_i, m z_i)| with w = M z + q, over the largest terms that w can have, max |q| + m sum |z|; m =
/// max |M| converts z to the unit of w.
[[nodiscard]] double lcp_residual(const LcpProblem& problem, const Eigen::VectorXd& z);

/// The proof by normal forces y >= 0, one per contact, about a contact problem. If they move nothing, W y = 0, and act
/// where the free gaps are closed in sum, y.q < 0, there are no forces f: any would leave y.u_n = y.q < 0, and so some
/// gap below zero.
struct ContactVerdict {
  double closed_m = 0.0;  ///< -y.q: sum of the gaps' closure, weighted by y.
  /// Solutions are at least 1/gap times the residual's scale |rho q| large; 0: there are none.
  double gap = std::numeric_limits<double>::infinity();
};

[[nodiscard]] ContactVerdict contact_verdict(const ContactProblem& problem, const Eigen::VectorXd& y);

/// The part of the torques that no pulling forces give.
struct MuscleDeficit {
  Eigen::VectorXd missing_Nm;  ///< tau - H f of least norm over f >= 0.
  /// Solutions are at least 1/gap times as large as |H^+ tau|; 0: there are none.
  double gap = std::numeric_limits<double>::infinity();
};

/// Explains and proves the infeasibility of a problem, limits aside: with r = missing, H'r <= 0 and tau.r > 0.
[[nodiscard]] MuscleDeficit explain_infeasible_muscles(const MuscleProblem& problem);

/// Computes the error of y >= 0 as a proof that there is no solution: one has |z| >= -y.q / |max(0, M'y)|, and the gap
/// is max |q| / max |M| over that. Zero is a proof; infinity if y.q >= 0.
[[nodiscard]] double lcp_infeasibility_gap(const LcpProblem& problem, const Eigen::VectorXd& y);

}  // namespace thenar
