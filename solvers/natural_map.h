// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A force or a gap in contact rows. In numbers, not an Eigen vector: inner loops keep these in registers.
struct Rows {
  double n, t1, t2;
};

/// Returns contact i's rows of a vector.
template <typename Vector>
Rows rows_of(const Eigen::MatrixBase<Vector>& v, Eigen::Index i) {
  return {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
}

inline void set_rows(Eigen::Ref<Eigen::VectorXd>& v, Eigen::Index i, const Rows& rows) {
  v[3 * i] = rows.n;
  v[3 * i + 1] = rows.t1;
  v[3 * i + 2] = rows.t2;
}

/// Returns rho_i = 3 / tr(W_ii), the natural map's force per gap [N/m]; zero for a contact that no force moves.
inline double rho_of_trace(double trace) { return trace > 0.0 ? 3.0 / trace : 0.0; }

/// Returns the residual's scale if it is usable: NaN where it is infinite, or so small that the squares of errors
/// underflow although movable contacts have a free motion. Zero without such contacts.
inline double judged_scale_N(double scale_N, bool moves) {
  // Squares of errors that are 1e-14 of the scale, all that a double resolves, still have all their digits.
  constexpr double kSmallest_N = 1e-140;
  const bool judged = moves ? scale_N >= kSmallest_N && std::isfinite(scale_N) : scale_N == 0.0;
  return judged ? scale_N : std::numeric_limits<double>::quiet_NaN();
}

inline bool is_inside_cone(const Rows& f, double mu) {
  const double limit = mu * f.n;
  return f.n >= 0.0 && f.t1 * f.t1 + f.t2 * f.t2 <= limit * limit;
}

/// Reduces a force into its cone: a pull becomes zero, a tangential force that is too large is scaled to mu f_n.
inline Rows inside_cone(const Rows& f, double mu) {
  if (!(f.n > 0.0)) return {0.0, 0.0, 0.0};
  const double limit = mu * f.n;
  const double squared = f.t1 * f.t1 + f.t2 * f.t2;
  if (squared <= limit * limit) return f;
  const double scale = limit / std::sqrt(squared);
  return {f.n, scale * f.t1, scale * f.t2};
}

/// A projected force: its normal force, and the remaining fraction of its tangential force.
struct Projection {
  double normal;
  double tangential_part;
};

inline Projection project(double f_n, double f_t, double mu) {
  // Without friction a pull has mu f_n = 0 as well: it is not inside.
  if (f_n >= 0.0 && f_t <= mu * f_n) return {f_n, 1.0};
  // Inside the polar cone the tip is nearest.
  if (mu * f_t <= -f_n) return {0.0, 0.0};
  // Beside the cone: the nearest point of the generator (1, mu).
  const double normal = (f_n + mu * f_t) / (1.0 + mu * mu);
  return {normal, mu * normal / f_t};
}

/// Computes | f - P_K(f - rho (delta + mu |delta_t| e_n)) |^2 of one contact [N^2], plus the square of f_n's rounding:
/// where no forces exist, solvers increase them until all else is lost to rounding, which must not count as a solution.
inline double natural_map_error_squared(double rho, double mu, const Rows& f, const Rows& delta) {
  const double x_n = f.n - rho * (delta.n + mu * std::sqrt(delta.t1 * delta.t1 + delta.t2 * delta.t2));
  const double x_1 = f.t1 - rho * delta.t1;
  const double x_2 = f.t2 - rho * delta.t2;
  const Projection p = project(x_n, std::sqrt(x_1 * x_1 + x_2 * x_2), mu);
  const double e_n = f.n - p.normal;
  const double e_1 = f.t1 - p.tangential_part * x_1;
  const double e_2 = f.t2 - p.tangential_part * x_2;
  const double rounding = std::numeric_limits<double>::epsilon() * f.n;
  return e_n * e_n + e_1 * e_1 + e_2 * e_2 + rounding * rounding;
}

}  // namespace thenar
