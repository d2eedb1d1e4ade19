#pragma once

#include <Eigen/Core>

namespace thenar {

/// How an LCP ended.
enum class LcpStatus {
  kSolved,       ///< z solves the problem.
  kInfeasible,   ///< Secondary ray: for the matrices of this project (M symmetric, positive semi-definite) no z exists.
  kBudgetSpent,  ///< The pivot budget ran out, or the input was not finite; z is zero.
};

/// What one LCP solve returns by value.
struct LcpReport {
  LcpStatus status = LcpStatus::kBudgetSpent;
  int pivots = 0;
};

/// The tableau that a solve works in: memory for problems of up to `capacity` rows, taken once.
class LcpWorkspace {
 public:
  explicit LcpWorkspace(Eigen::Index capacity);

  using Tableau = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Tableau tableau;                                ///< n x (2n + 2): columns w, z, artificial variable, right side.
  Eigen::Matrix<Eigen::Index, Eigen::Dynamic, 1> basis;  ///< The variable that each row holds.
  [[nodiscard]] Eigen::Index capacity() const { return basis.size(); }
};

/// Solves the linear complementarity problem
///     0 <= w = M z + q  _|_  z >= 0
/// by Lemke's method with the lexicographic rule, which cannot cycle [Murty 1988; eq. (19) of the paper].
///
/// Shapes    M n x n, q and z n, n <= work.capacity().
/// Requires  all values finite.
/// z         Out: the solution; on kInfeasible the ray's direction: z >= 0, M z >= 0, q.z < 0 (M symmetric PSD: M z = 0).
/// Cost      (2n + 2) n multiply-adds a pivot. Does not allocate or throw.
[[nodiscard]] LcpReport solve_lcp(const Eigen::Ref<const Eigen::MatrixXd>& M, const Eigen::Ref<const Eigen::VectorXd>& q,
                                  int max_pivots, LcpWorkspace& work, Eigen::Ref<Eigen::VectorXd> z) noexcept;

}  // namespace thenar
