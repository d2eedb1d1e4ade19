// SPDX-License-Identifier: Apache-2.0
#include "solvers/residual.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/natural_map.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

double rho(const MatrixRef& W, Index contact) {
  const Index n = 3 * contact;
  return rho_of_trace(W(n, n) + W(n + 1, n + 1) + W(n + 2, n + 2));
}

}  // namespace

Vector3d project_on_cone(const Vector3d& f, double mu) noexcept {
  const Projection p = project(f[0], f.tail<2>().norm(), mu);
  return {p.normal, p.tangential_part * f[1], p.tangential_part * f[2]};
}

double residual_scale_N(const ContactProblem& problem) noexcept {
  double squared = 0.0;
  for (Index i = 0; 3 * i < problem.delta_free.size(); ++i) {
    squared += (rho(problem.W, i) * problem.delta_free.segment<3>(3 * i)).squaredNorm();
  }
  return std::sqrt(squared);
}

double touching_m(const VectorRef& delta_free) noexcept {
  constexpr double kTouching = 1e-9;
  return delta_free.size() > 0 ? kTouching * delta_free.cwiseAbs().maxCoeff() : 0.0;
}

Residual natural_map(const ContactProblem& problem, const VectorRef& f, const VectorRef& delta) noexcept {
  double sum = 0.0, worst = 0.0;  // squared [N^2]
  bool moves = false;
  for (Index i = 0; i < problem.mu.size(); ++i) {
    const double rho_i = rho(problem.W, i);
    const double error = natural_map_error_squared(rho_i, problem.mu[i], rows_of(f, i), rows_of(delta, i));
    sum += error;
    worst = std::max(worst, error);
    moves = moves || (rho_i > 0.0 && !problem.delta_free.segment<3>(3 * i).isZero(0.0));
  }
  const double scale = judged_scale_N(residual_scale_N(problem), moves);
  if (scale == 0.0) return {};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (std::isnan(scale)) return {kInfinity, kInfinity};
  return {std::sqrt(sum) / scale, std::sqrt(worst) / scale};
}

}  // namespace thenar
