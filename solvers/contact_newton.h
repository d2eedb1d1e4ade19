// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solvers/contact_problem.h"
#include "solvers/contact_sweeps.h"

namespace thenar {

/// Stopping criteria of the accurate contact solve.
struct AccurateSettings {
  double tolerance = 1e-8;  ///< Stop at this natural-map residual [no unit]; see residual.h.
  int max_sweeps = 300;     ///< Limit of the Gauss-Seidel sweeps that precede Newton's method.
  int max_steps = 800;      ///< Newton steps of all stages together: bounds the time of one call.
};

/// Memory of accurate contact solves for up to `contacts` contacts, about 110 contacts^2 bytes; allocated once.
struct AccurateWorkspace {
  explicit AccurateWorkspace(Eigen::Index contacts);

  /// Out, one per contact: normal forces y that prove that no solution exists, scaled to a largest of 1; else zero.
  Eigen::VectorXd certificate;

  // Scratch of contact_newton.cpp.
  SweepWorkspace sweeps;
  std::vector<Eigen::Index> active;
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd f, last_good, delta, right, step, motion, trial_f, trial_delta, zero;
};

/// Result of one accurate solve.
struct AccurateReport {
  SolveReport solve;  ///< Status and residual; `sweeps` counts Gauss-Seidel sweeps.
  int steps = 0;      ///< Newton steps; 0 where Gauss-Seidel was enough.
};

/// Finds contact forces as solve_contacts does, also where Gauss-Seidel stalls: opposed walls, interference fits,
/// viscosity ratios, rigid bodies on more contacts than they have freedoms.
///
/// Method: Gauss-Seidel; if that does not converge, springs behind all contacts that stiffen from W's own compliance to
/// nothing, each stage solved from the last one by Newton's method on Alart and Curnier's map [Alart, Curnier 1991],
/// restricted to the contacts that are pressed; then the problem itself; then, where that failed, springs relaxed again
/// and again at the last forces. The forces of the least residual are kept.
///
/// work      For mu.size() contacts or more.
/// status    kNoSolution if no forces exist, and work.certificate proves it: y >= 0 with W y = 0, y.delta_free < 0.
///           Gaps delta >= 0 of any f would have 0 <= y.delta = y.delta_free < 0. Contacts with y > 0 press against one
///           another, and their gaps are closed in sum by -y.delta_free. It is found wherever there is one, and without
///           friction every problem without solution has one. kBudgetSpent: neither forces nor proof were found.
/// Cost      A sweep is 9n^2, a step about 18 k^3 multiply-adds for k pressed contacts; beyond max_steps it takes at
///           most 225 more, to look for the proof. Does not allocate or throw.
[[nodiscard]] AccurateReport solve_contacts_accurately(const ContactProblem& problem, const AccurateSettings& settings,
                                                       AccurateWorkspace& work, ContactSolution solution) noexcept;

}  // namespace thenar
