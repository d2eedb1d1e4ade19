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

double residual_scale_N(const MatrixRef& W, const VectorRef& delta_free) noexcept {
  double squared = 0.0;
  for (Index i = 0; 3 * i < delta_free.size(); ++i) {
    squared += (rho(W, i) * delta_free.segment<3>(3 * i)).squaredNorm();
  }
  return std::sqrt(squared);
}

double touching_m(const VectorRef& delta_free) noexcept {
  constexpr double kTouching = 1e-9;
  return delta_free.size() > 0 ? kTouching * delta_free.cwiseAbs().maxCoeff() : 0.0;
}

Residual natural_map(const MatrixRef& W, const VectorRef& delta_free, const VectorRef& mu, const VectorRef& f,
                     const VectorRef& delta) noexcept {
  double sum = 0.0, worst = 0.0;  // squared [N^2]
  bool moves = false;
  for (Index i = 0; i < mu.size(); ++i) {
    const Index n = 3 * i;
    const double error =
        natural_map_error_squared(rho(W, i), mu[i], {f[n], f[n + 1], f[n + 2]}, {delta[n], delta[n + 1], delta[n + 2]});
    sum += error;
    worst = std::max(worst, error);
    moves = moves || (rho(W, i) > 0.0 && !delta_free.segment<3>(n).isZero(0.0));
  }
  const double scale = judged_scale_N(residual_scale_N(W, delta_free), moves);
  if (scale == 0.0) return {};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (std::isnan(scale)) return {kInfinity, kInfinity};
  return {std::sqrt(sum) / scale, std::sqrt(worst) / scale};
}

double natural_map_residual(const MatrixRef& W, const VectorRef& delta_free, const VectorRef& mu, const VectorRef& f,
                            const VectorRef& delta) noexcept {
  return natural_map(W, delta_free, mu, f, delta).norm;
}

}  // namespace thenar
