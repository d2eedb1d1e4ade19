// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "solvers/gauss_seidel.h"

/// Problems of frictional contact, how Gauss-Seidel solves them, and the laws that its answers obey.
namespace thenar::gauss_seidel_runs {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

inline double rho(const ContactData& problem, Index i) { return 3.0 / problem.W.block<3, 3>(3 * i, 3 * i).trace(); }

/// The residual's unit: residual times this is a force.
inline double scale_N(const ContactData& problem) {
  double sum = 0.0;
  for (Index i = 0; i < problem.contacts(); ++i) {
    sum += (rho(problem, i) * problem.delta_free.segment<3>(3 * i)).squaredNorm();
  }
  return std::sqrt(sum);
}

struct Solution {
  SolveReport report;
  VectorXd f;
  VectorXd delta;
};

/// Every property holds for the plain sweeps and for the fast ones, which work in single precision and are accelerated.
class GaussSeidel : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] static bool fast() { return GetParam(); }

  [[nodiscard]] static Solution solve(const ContactData& problem, const GaussSeidelSettings& settings, VectorXd f) {
    VectorXd delta = VectorXd::Constant(f.size(), std::numeric_limits<double>::quiet_NaN());
    SolveReport report;
    if (fast()) {
      SweepWorkspace work(problem.contacts());
      report = solve_contacts(problem, settings, work, {f, delta});
    } else {
      report = solve_contacts(problem, settings, {f, delta});
    }
    return {report, f, delta};
  }

  [[nodiscard]] static Solution solve(const ContactData& problem, const GaussSeidelSettings& settings) {
    return solve(problem, settings, VectorXd::Zero(problem.delta_free.size()));
  }
};

inline MatrixXd random_matrix(Index rows, Index cols, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); });
}

/// Contacts that share a mechanism of nine freedoms, on a compliant surface; about half are pressed together.
inline ContactData random_problem(Index contacts, std::mt19937& random) {
  const MatrixXd J = random_matrix(3 * contacts, 9, random);
  ContactData problem;
  problem.W = 1e-5 * (0.1 * J * J.transpose() + MatrixXd::Identity(3 * contacts, 3 * contacts));
  problem.delta_free = 1e-5 * random_matrix(3 * contacts, 1, random);
  problem.mu = 0.5 * random_matrix(contacts, 1, random).cwiseAbs();
  return problem;
}

/// Signorini's and Coulomb's laws, contact by contact, on gaps computed here; shares no code with the solver.
///
/// The residual bounds e = |f - p|, p = P_K(f - rho u), u = delta + mu |delta_t| e_n, by tolerance * scale. By the
/// definition of a projection v = u + (p - f)/rho satisfies p in K, v in K* and p.v = 0 exactly, and it differs from u
/// by at most e/rho. Written out in f and delta, to first order in e, this gives the four tolerances below.
inline void expect_laws(const ContactData& problem, const Solution& solution, double tolerance) {
  const VectorXd& f = solution.f;
  const VectorXd delta = problem.W * f + problem.delta_free;
  const double e_N = tolerance * scale_N(problem);
  for (Index i = 0; i < problem.contacts(); ++i) {
    SCOPED_TRACE(testing::Message() << "contact " << i);
    const double mu = problem.mu[i];
    const double f_n = f[3 * i];
    const Vector2d f_t = f.segment<2>(3 * i + 1);
    const double delta_n = delta[3 * i];
    const Vector2d delta_t = delta.segment<2>(3 * i + 1);
    const double e_m = e_N / rho(problem, i);

    EXPECT_GE(f_n, 0.0);
    EXPECT_LE(f_t.norm(), mu * f_n * (1.0 + 1e-15));  // scaled back to the cone: the rounding of that
    EXPECT_GE(delta_n, -(1.0 + mu) * e_m);
    if (f_n > e_N) {
      EXPECT_LE(delta_n, (1.0 + mu) * e_m);
    }
    // Friction dissipates all it can: f_t.delta_t = -mu f_n |delta_t|.
    EXPECT_NEAR(f_t.dot(delta_t), -mu * f_n * delta_t.norm(),
                (1.0 + mu) * e_N * delta_t.norm() + 2.0 * (mu * f_n + e_N) * e_m);
  }
}

}  // namespace thenar::gauss_seidel_runs
