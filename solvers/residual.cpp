#include "solvers/residual.h"

#include <cmath>

#include "solvers/natural_map.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

double rho(const Eigen::Ref<const Eigen::MatrixXd>& W, Index contact) {
  const Index n = 3 * contact;
  return 3.0 / (W(n, n) + W(n + 1, n + 1) + W(n + 2, n + 2));
}

}  // namespace

Vector3d project_on_cone(const Vector3d& f, double mu) noexcept {
  const Projection p = project(f[0], f.tail<2>().norm(), mu);
  return {p.normal, p.tangential_part * f[1], p.tangential_part * f[2]};
}

double natural_map_residual(const Eigen::Ref<const Eigen::MatrixXd>& W,
                            const Eigen::Ref<const Eigen::VectorXd>& delta_free,
                            const Eigen::Ref<const Eigen::VectorXd>& mu, const Eigen::Ref<const Eigen::VectorXd>& f,
                            const Eigen::Ref<const Eigen::VectorXd>& delta) noexcept {
  double error = 0.0, scale = 0.0;  // squared [N^2]
  for (Index i = 0; i < mu.size(); ++i) {
    const Index n = 3 * i;
    const double rho_i = rho(W, i);
    error +=
        natural_map_error_squared(rho_i, mu[i], {f[n], f[n + 1], f[n + 2]}, {delta[n], delta[n + 1], delta[n + 2]});
    scale += (rho_i * delta_free.segment<3>(n)).squaredNorm();
  }
  return scale == 0.0 ? 0.0 : std::sqrt(error / scale);
}

}  // namespace thenar
