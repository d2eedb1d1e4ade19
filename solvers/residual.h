#pragma once

#include <Eigen/Core>

namespace thenar {

/// The projection of a force (n, t1, t2) onto the friction cone |f_t| <= mu f_n.
[[nodiscard]] Eigen::Vector3d project_on_cone(const Eigen::Vector3d& f, double mu) noexcept;

/// How far forces f with gaps delta = W f + delta_free are from Signorini's and Coulomb's laws:
///     | f - P_K(f - rho_i (delta + mu |delta_t| e_n)) |_2 / | rho_i delta_free |_2,   rho_i = 3 / tr(W_ii),
/// the natural map of De Saxce's form, scaled so that it has no unit. Zero where there is no contact or no free motion.
///
/// Shapes    W 3n x 3n; delta_free, f, delta 3n; mu n. Point i owns rows 3i..3i+2 = normal, tangent 1, tangent 2.
/// Cost      linear in n. Does not allocate or throw.
[[nodiscard]] double natural_map_residual(const Eigen::Ref<const Eigen::MatrixXd>& W,
                                          const Eigen::Ref<const Eigen::VectorXd>& delta_free,
                                          const Eigen::Ref<const Eigen::VectorXd>& mu,
                                          const Eigen::Ref<const Eigen::VectorXd>& f,
                                          const Eigen::Ref<const Eigen::VectorXd>& delta) noexcept;

}  // namespace thenar
