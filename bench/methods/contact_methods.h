// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "bench/cases/factored_contacts.h"
#include "bench/peers/peers.h"
#include "solvers/contact_newton.h"
#include "solvers/contact_sweeps.h"
#include "solvers/gauss_seidel.h"
#include "solvers/grouped_delassus.h"
#include "solvers/residual.h"

namespace thenar {

inline constexpr double kSolvedResidual = 1e-6;  ///< Natural-map residual of a solved problem.

/// Sweeps, or steps of Newton's method, which cost some hundred sweeps each, after which a contact solver is given up.
[[nodiscard]] inline int ample_budget(std::string_view method) {
  if (method == "siconos_nsn") return 200;
  return method.starts_with("Newton") ? AccurateSettings{}.max_steps : 3000;
}

/// Tolerances to be tried for kSolvedResidual until one is enough: peers stop by measures of their own.
[[nodiscard]] inline std::vector<double> tolerances_to_solve(const ContactMethod& method) {
  return method.stops_by == ContactMethod::kNaturalMap ? std::vector{kSolvedResidual} : std::vector{1e-4, 1e-6, 1e-8};
}

/// The natural-map residual of forces; no number where they are none.
[[nodiscard]] inline double residual_of(const ContactProblem& problem, const Eigen::VectorXd& f) {
  if (!f.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  return natural_map(problem, f, problem.W * f + problem.delta_free).norm;
}

/// Single-precision sweeps on the operator in factors: what the contact tick does.
[[nodiscard]] inline ContactSolver in_factors(const GroupedContactProblem& problem) {
  auto delta = std::make_shared<Eigen::VectorXd>(problem.delta_free.size());
  auto work = std::make_shared<GroupedWorkspace>(problem.mu.size(), problem.W.groups());
  return [problem, delta, work](double tolerance, int budget, Eigen::VectorXd& f) {
    (void)solve_contacts(problem, {.tolerance = tolerance, .max_sweeps = budget}, *work, {f, *delta});
  };
}

/// A method of a dense W that forms the matrix in every call, as the contact tick has to.
[[nodiscard]] inline ContactSolver forming_w(const ContactMethod& method, const GroupedContactProblem& problem) {
  auto W = std::make_shared<Eigen::MatrixXd>(problem.delta_free.size(), problem.delta_free.size());
  return [W, factors = problem.W, solve = method.prepare({*W, problem.delta_free, problem.mu})](
             double tolerance, int budget, Eigen::VectorXd& f) {
    factors.to_dense(*W);
    solve(tolerance, budget, f);
  };
}

inline constexpr const char* kInFactors = "Gauss-Seidel, W in factors";

/// Our contact solvers of a dense W: single-precision sweeps, accelerated; plain sweeps in double precision, without a
/// workspace, as published; and Gauss-Seidel, then homotopy and Newton, the accurate one.
[[nodiscard]] inline std::vector<ContactMethod> our_contact_methods() {
  using Eigen::VectorXd;
  static_assert(AccurateSettings{}.max_sweeps == 300);
  const auto sweeps = [](const ContactProblem& problem) -> ContactSolver {
    auto delta = std::make_shared<VectorXd>(problem.delta_free.size());
    return [problem, delta](double tolerance, int budget, VectorXd& f) {
      (void)solve_contacts(problem, {.tolerance = tolerance, .max_sweeps = budget}, {f, *delta});
    };
  };
  const auto gauss_seidel = [](const ContactProblem& problem) -> ContactSolver {
    auto delta = std::make_shared<VectorXd>(problem.delta_free.size());
    auto work = std::make_shared<SweepWorkspace>(problem.mu.size());
    return [problem, delta, work](double tolerance, int budget, VectorXd& f) {
      (void)solve_contacts(problem, {.tolerance = tolerance, .max_sweeps = budget}, *work, {f, *delta});
    };
  };
  // The budget is of Newton steps.
  const auto newton = [](const ContactProblem& problem) -> ContactSolver {
    auto delta = std::make_shared<VectorXd>(problem.delta_free.size());
    auto work = std::make_shared<AccurateWorkspace>(problem.mu.size());
    return [problem, delta, work](double tolerance, int budget, VectorXd& f) {
      (void)solve_contacts_accurately(problem, {.tolerance = tolerance, .max_steps = budget}, *work, {f, *delta});
    };
  };
  return {{"Gauss-Seidel, W as a matrix", ContactMethod::kNaturalMap, gauss_seidel},
          {"plain sweeps", ContactMethod::kNaturalMap, sweeps},
          {"Newton after 300 sweeps", ContactMethod::kNaturalMap, newton}};
}

}  // namespace thenar
