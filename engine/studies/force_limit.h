#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// The most bounded forces, and variables in all: what a hand of 64 muscles and five fingers has.
inline constexpr Eigen::Index kMaxBounded = 64, kMaxLimitSize = 80;

/// A linear program over forces that pull, forces in friction cones and numbers that are free,
///     max c.x,   E x = 0,   0 <= x_j <= most_j for the first ones,   |x_t| <= mu x_n for each cone.
/// x = 0 always keeps it.
struct ForceProgram {
  Eigen::MatrixXd E;                ///< Rows may depend on others.
  Eigen::VectorXd c;                ///< At most kMaxLimitSize.
  Eigen::VectorXd most;             ///< At most kMaxBounded; finite, not all 0 [N].
  std::vector<Eigen::Index> cones;  ///< Index of n, behind the bounded ones; t1 and t2 follow it, if mu > 0.
  double friction = 0.0;            ///< mu of all cones.
};

enum class LimitStatus {
  kOptimal,
  kUnbounded,  ///< Nothing stops c.x, or only at 1e4 times the largest bound.
  kUnproved,   ///< No answer with a proof: rounding, or too many steps.
};

struct ForceLimit {
  LimitStatus status = LimitStatus::kUnproved;
  double value = 0.0;  ///< c.x
  Eigen::VectorXd x;
  /// What one more of each bound gives, >= 0: the dual. Its value, prices.most, is c.x at the optimum.
  Eigen::VectorXd price;
  /// How far x and the prices are from proving each other, as a share of the largest bound, and of |c|: bounds, planes,
  /// equations, the dual's equations and signs, and the gap between primal and dual.
  double residual = std::numeric_limits<double>::infinity();
};

/// Finds it between planes that touch the cones, of which each cone that its force leaves gets one more, until none is
/// left by more than 1e-7 of the largest bound. With planes it is a linear program, solved by points that are nearest
/// to the last one plus t c [Rockafellar 1976, which ends after finitely many], each by the dual active set
/// (solvers/dual_active_set.h). The prices are those with which the rows where it stops make c, by least squares. t
/// grows until they prove it.
///
/// Accuracy  residual <= 1e-9 between planes: primal and dual are alike to that.
/// Cost      a millisecond for 40 variables.
[[nodiscard]] ForceLimit find_force_limit(const ForceProgram& program);

}  // namespace thenar
