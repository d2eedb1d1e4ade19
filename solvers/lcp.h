// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A linear complementarity problem:
///     0 <= w = M z + q  _|_  z >= 0.
/// A view: the numbers are owned elsewhere.
struct LcpProblem {
  Eigen::Ref<const Eigen::MatrixXd> M;  ///< n x n.
  Eigen::Ref<const Eigen::VectorXd> q;  ///< n.
};

/// An LCP that owns its numbers.
struct LcpData {
  Eigen::MatrixXd M;
  Eigen::VectorXd q;

  operator LcpProblem() const { return {M, q}; }
};

/// Outcome of an LCP.
enum class LcpStatus {
  kSolved,       ///< z solves the problem.
  kInfeasible,   ///< No solution exists, and z proves it.
  kBudgetSpent,  ///< No answer: the pivots ran out, or the input was not finite, or rounding spoiled the result; z = 0.
};

/// Result of one LCP solve.
struct LcpReport {
  LcpStatus status = LcpStatus::kBudgetSpent;
  int pivots = 0;
};

/// Memory of solves of up to `capacity` rows, allocated once.
class LcpWorkspace {
 public:
  explicit LcpWorkspace(Eigen::Index capacity);

  [[nodiscard]] Eigen::Index capacity() const { return basis.size(); }

  // A smaller problem uses the front.
  Eigen::VectorXd dictionary;  ///< By columns: one for each variable out of the basis, then the right side.
  Eigen::VectorXd scratch;     ///< One column.
  Eigen::Matrix<Eigen::Index, Eigen::Dynamic, 1> basis;      ///< The variable that each row holds.
  Eigen::Matrix<Eigen::Index, Eigen::Dynamic, 1> column_of;  ///< The column of each variable, -1 in the basis.
};

/// Returns a pivot budget far above the need of this project's problems, about n pivots, though 2^n is possible.
[[nodiscard]] constexpr int usual_pivot_budget(Eigen::Index n) { return 50 + 10 * static_cast<int>(n); }

/// Solves an LCP by Lemke's method with the lexicographic rule, which cannot cycle [Murty 1988; eq. (19) of the paper].
///
/// problem   At most work.capacity() rows. Any M; an answer is guaranteed for symmetric positive semi-definite M and
///           for P-matrices.
/// max_pivots  Bounds the time of one call: some families take 2^n pivots. When they are spent the status says so.
/// z         Out, n: the solution; on kInfeasible the direction of the secondary ray, z >= 0 with M'z <= 0 (M z = 0 if
///           M is symmetric positive semi-definite) and q.z < 0; on kBudgetSpent zero.
/// Accuracy  Pivots below 1e-11 of the largest entry count as zero. Both answers are checked in the problem as given.
/// Cost      (n + 2) n multiply-adds a pivot. Does not allocate or throw.
[[nodiscard]] LcpReport solve_lcp(const LcpProblem& problem, int max_pivots, LcpWorkspace& work,
                                  Eigen::Ref<Eigen::VectorXd> z) noexcept;

}  // namespace thenar
