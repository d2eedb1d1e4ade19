#pragma once

#include <memory>

#include "bench/factored_contacts.h"
#include "bench/peers.h"
#include "solvers/contact_newton.h"
#include "solvers/contact_sweeps.h"
#include "solvers/gauss_seidel.h"
#include "solvers/grouped_delassus.h"

namespace thenar {

/// The accurate solver after so many sweeps; the budget is of Newton steps.
[[nodiscard]] inline ContactMethod newton_after_sweeps(const char* name, int max_sweeps) {
  return {name, ContactMethod::kNaturalMap,
          [max_sweeps](const Eigen::MatrixXd& W, const Eigen::VectorXd& delta_free,
                       const Eigen::VectorXd& mu) -> ContactSolver {
            auto delta = std::make_shared<Eigen::VectorXd>(delta_free.size());
            auto work = std::make_shared<AccurateWorkspace>(mu.size());
            return [&W, &delta_free, &mu, delta, work, max_sweeps](double tolerance, int budget, Eigen::VectorXd& f) {
              const AccurateSettings settings{.tolerance = tolerance, .max_sweeps = max_sweeps, .max_steps = budget};
              (void)solve_contacts_accurately(W, delta_free, mu, settings, *work, f, *delta);
            };
          }};
}

/// Single-precision sweeps on the operator in factors: what the contact tick does.
[[nodiscard]] inline ContactSolver in_factors(const FactoredContacts& W, const Eigen::VectorXd& delta_free,
                                              const Eigen::VectorXd& mu) {
  auto delta = std::make_shared<Eigen::VectorXd>(delta_free.size());
  auto work = std::make_shared<GroupedWorkspace>(mu.size(), std::ssize(W.begin) - 1);
  return [&W, &delta_free, &mu, delta, work](double tolerance, int budget, Eigen::VectorXd& f) {
    (void)solve_contacts(W.operator_of(), delta_free, mu, {.tolerance = tolerance, .max_sweeps = budget}, *work, f,
                         *delta);
  };
}

/// A method of a dense W that forms the matrix in every call, as the contact tick has to.
[[nodiscard]] inline ContactSolver forming_w(const ContactMethod& method, const FactoredContacts& factors,
                                             const Eigen::VectorXd& delta_free, const Eigen::VectorXd& mu) {
  auto W = std::make_shared<Eigen::MatrixXd>(delta_free.size(), delta_free.size());
  return [W, &factors, solve = method.prepare(*W, delta_free, mu)](double tolerance, int budget, Eigen::VectorXd& f) {
    factors.operator_of().to_dense(*W);
    solve(tolerance, budget, f);
  };
}

/// Our contact solvers of a dense W, the first and the last under the names of `thenar solve`:
///     gauss_seidel  single-precision sweeps, accelerated
///     sweeps        plain sweeps in double precision, without a workspace
///     newton        Gauss-Seidel, then homotopy and Newton: the accurate one
[[nodiscard]] inline std::vector<ContactMethod> our_contact_methods() {
  using Eigen::MatrixXd;
  using Eigen::VectorXd;
  const auto sweeps = [](const MatrixXd& W, const VectorXd& delta_free, const VectorXd& mu) -> ContactSolver {
    auto delta = std::make_shared<VectorXd>(delta_free.size());
    return [&W, &delta_free, &mu, delta](double tolerance, int budget, VectorXd& f) {
      (void)solve_contacts(W, delta_free, mu, {.tolerance = tolerance, .max_sweeps = budget}, f, *delta);
    };
  };
  const auto gauss_seidel = [](const MatrixXd& W, const VectorXd& delta_free, const VectorXd& mu) -> ContactSolver {
    auto delta = std::make_shared<VectorXd>(delta_free.size());
    auto work = std::make_shared<SweepWorkspace>(mu.size());
    return [&W, &delta_free, &mu, delta, work](double tolerance, int budget, VectorXd& f) {
      (void)solve_contacts(W, delta_free, mu, {.tolerance = tolerance, .max_sweeps = budget}, *work, f, *delta);
    };
  };
  return {{"gauss_seidel", ContactMethod::kNaturalMap, gauss_seidel},
          {"sweeps", ContactMethod::kNaturalMap, sweeps},
          newton_after_sweeps("newton", AccurateSettings{}.max_sweeps)};
}

}  // namespace thenar
