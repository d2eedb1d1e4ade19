#pragma once

#include <Eigen/Core>

#include "solvers/contact_problem.h"

namespace thenar {

/// The projection of a force (n, t1, t2) onto the friction cone |f_t| <= mu f_n.
[[nodiscard]] Eigen::Vector3d project_on_cone(const Eigen::Vector3d& f, double mu) noexcept;

/// What forces in frozen contact space miss Signorini's and Coulomb's laws by [no unit].
struct Residual {
  double norm = 0.0;   ///< Of all contacts, 2-norm.
  double worst = 0.0;  ///< Of the worst single contact.
};

/// The force that the residual is in units of: | rho_i delta_free |_2 [N].
[[nodiscard]] double residual_scale_N(const ContactProblem& problem) noexcept;

/// A contact that no force moves, W_nn = 0, is open from minus this gap on [m], and without solution below: 1e-9 of the
/// largest |delta_free|, far above the rounding of gaps and far below what is of interest.
[[nodiscard]] double touching_m(const Eigen::Ref<const Eigen::VectorXd>& delta_free) noexcept;

/// How far forces f with gaps delta = W f + delta_free are from Signorini's and Coulomb's laws:
///     | f - P_K(f - rho_i (delta + mu |delta_t| e_n)) |_2 / | rho_i delta_free |_2,   rho_i = 3 / tr(W_ii),
/// the natural map of De Saxce's form, scaled so that it has no unit. Zero where there is no contact or no free motion.
/// A contact that no force moves, W_ii = 0, has no part in it: it is open or without solution. Infinite where the scale
/// is infinite or below 1e-140 N, for then errors cannot be told from zero.
///
/// Cost      linear in n. Does not allocate or throw.
[[nodiscard]] Residual natural_map(const ContactProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& f,
                                   const Eigen::Ref<const Eigen::VectorXd>& delta) noexcept;

}  // namespace thenar
