// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "solvers/contact_problem.h"

namespace thenar {

/// A contact of a body with six degrees of freedom and a fixed body: a table, a wall.
struct GroundContact {
  using Jacobian = Eigen::Matrix<double, 3, 6>;
  Jacobian J;                  ///< Change of gap and slips with the body's motion; rows n, t1, t2.
  Eigen::Vector3d delta_free;  ///< Gap, and slips less the remaining shear of the last force, without motion [m].
  double mu = 0.0;
};

/// A problem of contacts of one body with the ground, which has an independent compliance c at each of them:
///     x = M (w + sum_i J_i' f_i),   delta_i = J_i x + delta_free_i + c f_i,
/// Signorini's and Coulomb's laws between f_i and delta_i. Given x, each force is known: it is a function of
/// d_i = J_i x + delta_free_i alone,
///     f_n = max(0, -d_n) / c,    f_t = -d_t / c, scaled back to |f_t| <= mu f_n,
/// so that the unknowns are six, however many contacts there are; c also decides between forces that a rigid ground
/// would leave open.
struct GroundProblem {
  using Motion = Eigen::Matrix<double, 6, 1>;
  std::span<const GroundContact> contacts;
  double compliance = 0.0;  ///< c > 0 [m/N].
  Motion mobility;          ///< The diagonal of M, > 0.
};

/// Value of `missing` at which a solve stops.
inline constexpr double kGroundTolerance = 1e-11;

struct GroundReport {
  SolveStatus status = SolveStatus::kConverged;
  int steps = 0;         ///< Number of Newton steps.
  double missing = 0.0;  ///< Residual x - M (w + J' f) relative to its terms, in the norm of M^-1.
};

/// Four contacts side by side, for vectorised computation; lanes without one have a gap of 1 m and no Jacobian.
struct GroundLanes {
  using Lanes = Eigen::Array<double, 4, 1>;
  std::array<std::array<Lanes, 6>, 3> J;
  std::array<Lanes, 3> delta_free;
  Lanes mu;
};

/// Memory of the solves of one body with up to `contacts` contacts.
struct GroundWorkspace {
  explicit GroundWorkspace(Eigen::Index contacts = 0) : f(contacts, Eigen::Vector3d::Zero()) {
    lanes.reserve((contacts + 3) / 4);
  }

  GroundProblem::Motion x = GroundProblem::Motion::Zero();  ///< In: a guess. Out: the body's motion.
  std::vector<Eigen::Vector3d> f;                           ///< Out: force of each contact [N].
  std::vector<GroundLanes> lanes;                           // The contacts, as set_ground() has them.
  // J' f at a motion for a compliance; 0: not known.
  GroundProblem::Motion x_known = GroundProblem::Motion::Zero(), wrench = GroundProblem::Motion::Zero();
  double known_compliance = 0.0;
  double compliance = 0.0;  // Compliance of the forces; 0: there are none.
  // Inverse of M^-1 + J' K J where it was last computed; it often remains good enough.
  Eigen::Matrix<double, 6, 6> inverse_slope = Eigen::Matrix<double, 6, 6>::Zero();
  bool has_slope = false;
};

/// Finds the motion x of the body that moves by x_free = M w without the ground, and the forces, by Newton's method on
/// the six equations. Where friction makes that cycle, the ground starts softer and stiffens.
///
/// status    kBudgetSpent: forces of a softer ground, inside their cones; `missing` is the error of x.
/// Cost      About 20 multiply-adds a contact and step with the last slope, 100 with a new one; mostly a step or two.
///           Does not allocate or throw.
[[nodiscard]] GroundReport solve_ground(const GroundProblem& problem, const GroundProblem::Motion& x_free,
                                        GroundWorkspace& work, double tolerance = kGroundTolerance) noexcept;

/// Solves in parts, for repeated solves with the same contacts (at most as many as the workspace has room for):
/// set_ground() once, solve_set_ground() whenever x_free changes, and write_forces() at the end.
void set_ground(std::span<const GroundContact> contacts, GroundWorkspace& work) noexcept;
[[nodiscard]] GroundReport solve_set_ground(const GroundProblem& problem, const GroundProblem::Motion& x_free,
                                            GroundWorkspace& work, double tolerance = kGroundTolerance) noexcept;
void write_forces(const GroundProblem& problem, GroundWorkspace& work) noexcept;

/// Computes the ground's stiffness against small motions, sum J' K J at work.x over the contacts that are set, K =
/// -df/dd. Sliding contacts count without the coupling of friction to normal force: symmetric, positive semi-definite.
[[nodiscard]] Eigen::Matrix<double, 6, 6> ground_stiffness(const GroundProblem& problem,
                                                           const GroundWorkspace& work) noexcept;

}  // namespace thenar
