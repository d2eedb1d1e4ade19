// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>

#include "solvers/grasp_problem.h"
#include "solvers/lcp.h"

namespace thenar {

struct GraspReport {
  GraspStatus status = GraspStatus::kBudgetSpent;
  /// Pivots of Lemke's method; faces added or dropped by the active set; for the exact cone planes and Newton steps,
  /// too.
  int iterations = 0;
  /// Error of the answer [no unit]. Optimal: grasp_kkt_error of the forces. Infeasible: the size of the least forces
  /// that give the wrench without cones, over the lower bound of a solution's (infeasibility_gap).
  double residual = std::numeric_limits<double>::infinity();
  /// Certificate of the answer, per newton of force and per newton metre of torque about `centre_m`, world axes.
  /// Optimal: the multiplier l of G f = W^d, with f = P_K(G' l - c). Infeasible: a twist l on which the wrench does
  /// work, W^d.l > 0, and on which no force inside the cones does any, P_K(G' l) = 0.
  Vector6d multiplier = Vector6d::Zero();
};

/// Memory of the grasp-force solves; allocated once.
class GraspWorkspace {
 public:
  GraspWorkspace();

  static constexpr Eigen::Index kMaxRows = 5 * kMaxGraspContacts;
  using RowVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxRows, 1>;

  LcpWorkspace lcp;
  Eigen::Matrix<double, kMaxRows, 6> N;  ///< A Q', with Q's rows those of G made orthonormal.
  /// Matrix of the LCP in its first 5n rows; the rest is padding.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxRows, kMaxRows> M;
  RowVector q, z;
};

/// Computes the grasp map G [6, 7], 6 x 3n, from contact forces (world axes) to the object's wrench about `centre_m`.
void grasp_map(std::span<const GraspContact> contacts, const Eigen::Vector3d& centre_m, Eigen::Ref<Eigen::MatrixXd> G);

/// Finds the contact forces of eq. (15),
///     min 1/2 f'f + c'f,  G f = W^d,  f_i in the friction cone K_i of contact i,   c_i = -lambda_i n_i,
/// for 1 to 8 contacts: the projection of -c on the forces that give the wrench inside the cones, which is unique.
/// GG' is factorised about the contacts' centroid, and Q f = w solved for in contact axes: see reduced_grasp.h.
/// Pyramid: a dual active set [Goldfarb and Idnani 1983] on the faces of the pyramids. Exact cone: planes that
/// touch it, then semismooth Newton (exact_cone.h).
///
/// f         Out: 3n forces on the object, world axes [N]; on failure unchanged.
/// Accuracy  Every answer is checked: residual <= 1e-9, or what rounding of the multiplier leaves, 1e-11 of it, where
///           cones are so thin that it is 1e2 and more times the forces; laws are kept to 1e-9 of the forces always.
///           Contacts that deviate from a line by a fraction s of their distances cost 1e-16/s of the forces.
/// Requires  contact frames orthonormal to rounding; friction >= 0; one grip a contact, or none.
/// Does not allocate or throw; the same problem gives the same bits.
[[nodiscard]] GraspReport solve_grasp_forces(const GraspProblem& problem, Eigen::Ref<Eigen::VectorXd> f) noexcept;

/// Returns the name of the method of solve_grasp_forces, for a table.
[[nodiscard]] const char* grasp_method(FrictionCone cone) noexcept;

/// Finds the forces of eq. (15) with the pyramid by the paper's method, Lemke's on the LCP of eq. (19):
///     M = A pi A',  q = -A pi c + A G^+ W^d,  f = pi (A' z - c) + G^+ W^d,   pi = I - G^+ G.
/// A holds five rows a contact [10].
/// Requires  problem.cone is kPyramid.
/// Accuracy  1e-10 of the forces at a friction of 0.1 and more; each tenth of it costs some three digits, and below
///           1e-5 it counts as none. Without friction at all accuracy is full again.
/// Cost      an LCP of 5n rows.
[[nodiscard]] GraspReport solve_grasp_forces_by_lemke(const GraspProblem& problem, GraspWorkspace& work,
                                                      Eigen::Ref<Eigen::VectorXd> f) noexcept;

/// Computes the KKT error of forces f with a multiplier l in the problem as given, relative to the forces: the largest
/// of |f - P_K(G' l - c)| / s, and |R^-1 (G f - W^d)| / s with R R' = G G' (the least forces that would make up for the
/// wrench that is missing), s the larger of |f| and |c|. Zero at the optimum, and there only. From plain G: not for a
/// loop.
[[nodiscard]] double grasp_kkt_error(const GraspProblem& problem, const Vector6d& multiplier,
                                     const Eigen::Ref<const Eigen::VectorXd>& f) noexcept;

/// Computes the error of the twist l as a proof that no forces exist: feasible forces have at least the size W^d.l /
/// |P_K(G' l)|, and the gap is the least size without cones, |G^+ W^d|, over that. Zero is a proof; infinity if W^d.l
/// <= 0.
[[nodiscard]] double infeasibility_gap(const GraspProblem& problem, const Vector6d& twist) noexcept;

}  // namespace thenar
