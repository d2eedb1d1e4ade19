// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "solvers/contact_problem.h"

namespace thenar {

/// Returns the projection of a force (n, t1, t2) onto the friction cone |f_t| <= mu f_n.
[[nodiscard]] Eigen::Vector3d project_on_cone(const Eigen::Vector3d& f, double mu) noexcept;

/// The error of forces in Signorini's and Coulomb's laws in frozen contact space [no unit].
struct Residual {
  double norm = 0.0;   ///< 2-norm over all contacts.
  double worst = 0.0;  ///< Error of the worst single contact.
};

/// Returns the force by which the residual is scaled, | rho_i delta_free |_2 [N].
[[nodiscard]] double residual_scale_N(const ContactProblem& problem) noexcept;

/// Returns the gap, negated, from which a contact that no force moves, W_nn = 0, is open [m]; below it has no solution.
/// It is 1e-9 of the largest |delta_free|, far above the rounding of gaps and far below any gap of interest.
[[nodiscard]] double touching_m(const Eigen::Ref<const Eigen::VectorXd>& delta_free) noexcept;

/// Computes the error of forces f with gaps delta = W f + delta_free in Signorini's and Coulomb's laws:
///     | f - P_K(f - rho_i (delta + mu |delta_t| e_n)) |_2 / | rho_i delta_free |_2,   rho_i = 3 / tr(W_ii),
/// the natural map of De Saxce's form, scaled so that it has no unit. Zero without contact or free motion. A contact
/// that no force moves, W_ii = 0, is not counted: it is open or without solution. Infinite where the scale is infinite
/// or below 1e-140 N, for then errors cannot be distinguished from zero.
///
/// Cost      linear in n. Does not allocate or throw.
[[nodiscard]] Residual natural_map(const ContactProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& f,
                                   const Eigen::Ref<const Eigen::VectorXd>& delta) noexcept;

}  // namespace thenar
