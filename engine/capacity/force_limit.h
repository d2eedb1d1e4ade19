// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// Largest numbers of bounded forces, and of all variables: those of a hand with 64 muscles and five fingers.
inline constexpr Eigen::Index kMaxBounded = 64, kMaxLimitSize = 80;

/// A linear program over forces that pull, forces in friction cones and numbers that are free,
///     max c.x,   E x = 0,   0 <= x_j <= most_j for the first ones,   |x_t| <= mu x_n for each cone.
/// x = 0 is always feasible.
struct ForceProgram {
  Eigen::MatrixXd E;                ///< Rows may depend on others.
  Eigen::VectorXd c;                ///< At most kMaxLimitSize.
  Eigen::VectorXd most;             ///< At most kMaxBounded; finite, not all 0 [N].
  std::vector<Eigen::Index> cones;  ///< Index of n, behind the bounded ones; t1 and t2 follow it, if mu > 0.
  double friction = 0.0;            ///< mu of all cones.
};

enum class LimitStatus {
  kOptimal,
  kUnbounded,  ///< c.x is unbounded, or exceeds 1e4 times the largest bound.
  kUnproved,   ///< No answer with a proof: rounding, or too many steps.
};

struct ForceLimit {
  LimitStatus status = LimitStatus::kUnproved;
  double value = 0.0;  ///< c.x
  Eigen::VectorXd x;
  /// The dual, >= 0: gain of c.x per unit of each bound. Its value, prices.most, is c.x at the optimum.
  Eigen::VectorXd price;
  /// Error of x and the prices as a proof of each other, relative to the largest bound, and to |c|: bounds, planes,
  /// equations, the dual's equations and signs, and the gap between primal and dual.
  double residual = std::numeric_limits<double>::infinity();
};

/// Solves the program with planes tangent to the cones; each cone that its force leaves gets one more, until none is
/// left by more than 1e-7 of the largest bound. With planes it is a linear program, solved by the points nearest to the
/// last one plus t c [Rockafellar 1976, finite], each by the dual active set (solvers/dual_active_set.h). The prices
/// are the least-squares combination of the active rows to c; t increases until they prove the optimum.
///
/// Accuracy  residual <= 1e-9 between planes: primal and dual agree to that.
/// Cost      a millisecond for 40 variables.
[[nodiscard]] ForceLimit find_force_limit(const ForceProgram& program);

}  // namespace thenar
