#include "solvers/residual.h"

#include <cmath>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

double rho(const Eigen::Ref<const Eigen::MatrixXd>& W, Index contact) {
  const Index n = 3 * contact;
  return 3.0 / (W(n, n) + W(n + 1, n + 1) + W(n + 2, n + 2));
}

/// Where a force goes when it is projected: to this normal force, and to this part of its tangential force.
struct Projection {
  double normal;
  double tangential_part;
};

Projection project(double f_n, double f_t, double mu) {
  // Without friction a pull has mu f_n = 0 as well: it is not inside.
  if (f_n >= 0.0 && f_t <= mu * f_n) return {f_n, 1.0};
  // In the polar cone: the tip is nearest.
  if (mu * f_t <= -f_n) return {0.0, 0.0};
  // Beside the cone: the nearest point of the generator (1, mu).
  const double normal = (f_n + mu * f_t) / (1.0 + mu * mu);
  return {normal, mu * normal / f_t};
}

double norm(double x, double y) { return std::sqrt(x * x + y * y); }

double square(double x) { return x * x; }

}  // namespace

Vector3d project_on_cone(const Vector3d& f, double mu) noexcept {
  const Projection p = project(f[0], norm(f[1], f[2]), mu);
  return {p.normal, p.tangential_part * f[1], p.tangential_part * f[2]};
}

double natural_map_error_N(const Eigen::Ref<const Eigen::MatrixXd>& W, const Eigen::Ref<const Eigen::VectorXd>& mu,
                           const Eigen::Ref<const Eigen::VectorXd>& f,
                           const Eigen::Ref<const Eigen::VectorXd>& delta) noexcept {
  double sum = 0.0;
  for (Index i = 0; i < mu.size(); ++i) {
    // In numbers, not vectors: this runs every sweep, and numbers stay in registers.
    const Index n = 3 * i;
    const double rho_i = rho(W, i);
    const double x_n = f[n] - rho_i * (delta[n] + mu[i] * norm(delta[n + 1], delta[n + 2]));
    const double x_1 = f[n + 1] - rho_i * delta[n + 1];
    const double x_2 = f[n + 2] - rho_i * delta[n + 2];
    const Projection p = project(x_n, norm(x_1, x_2), mu[i]);
    sum += square(f[n] - p.normal) + square(f[n + 1] - p.tangential_part * x_1) +
           square(f[n + 2] - p.tangential_part * x_2);
  }
  return std::sqrt(sum);
}

double free_motion_force_N(const Eigen::Ref<const Eigen::MatrixXd>& W,
                           const Eigen::Ref<const Eigen::VectorXd>& delta_free) noexcept {
  double sum = 0.0;
  for (Index i = 0; 3 * i < delta_free.size(); ++i) {
    sum += (rho(W, i) * delta_free.segment<3>(3 * i)).squaredNorm();
  }
  return std::sqrt(sum);
}

double natural_map_residual(const Eigen::Ref<const Eigen::MatrixXd>& W,
                            const Eigen::Ref<const Eigen::VectorXd>& delta_free,
                            const Eigen::Ref<const Eigen::VectorXd>& mu, const Eigen::Ref<const Eigen::VectorXd>& f,
                            const Eigen::Ref<const Eigen::VectorXd>& delta) noexcept {
  const double scale = free_motion_force_N(W, delta_free);
  return scale == 0.0 ? 0.0 : natural_map_error_N(W, mu, f, delta) / scale;
}

}  // namespace thenar
