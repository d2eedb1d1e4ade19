// SPDX-License-Identifier: Apache-2.0
#include "solvers/lcp.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace thenar {
namespace {

using Eigen::Index;
using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

// M and q are scaled to a largest entry between 1 and 2. Pivoting turns a zero into rounding of the largest entries of
// its column; the smallest entries that matter, squares of a friction of 1e-5, are about 1e-10.
constexpr double kZeroPivot = 1e-11;
constexpr double kTie = 1e-12;
// A solution must hold in the problem as given to this part of its terms, and a proof that there is none to this part
// of M: it excludes solutions up to z of 1e8. A ray is no more exact where a matrix is nearly of less rank than it has.
constexpr double kTrust = 1e-9;
constexpr double kProof = 1e-8;
constexpr double kBeyond = 1e6;

// Columns are padded with zeros to whole blocks, so that loops over them have no remainder.
constexpr Index kBlock = 8;
using Block = Eigen::Array<double, kBlock, 1>;
constexpr Index column_length(Index n) { return (n + kBlock - 1) / kBlock * kBlock; }
Eigen::Map<Block> block(double* column, Index i) { return Eigen::Map<Block>(column + i); }

/// Returns the largest power of two up to x, which scales without rounding; 1 for 0.
double power_of_two(double x) { return x > 0.0 ? std::ldexp(1.0, std::ilogb(x)) : 1.0; }

/// The equations w = q + M z + z0 (1..1)' solved for the variables in the basis, x_B = right side + sum of column times
/// variable over those out of it. The condensed form: the unit vectors of the basis are not stored. Variables: w_i is
/// i, z_i is n + i, the artificial z0 is 2n.
struct Dictionary {
  Index n;
  double* entries;
  double* scratch;
  Index* basis;
  Index* column_of;

  [[nodiscard]] Index artificial() const { return 2 * n; }
  [[nodiscard]] Index complement(Index variable) const { return variable < n ? variable + n : variable - n; }
  [[nodiscard]] Index length() const { return column_length(n); }
  [[nodiscard]] double* column(Index j) const { return entries + j * length(); }
  [[nodiscard]] double* right_side() const { return column(n + 1); }
};

void fill(const Dictionary& t, const LcpProblem& problem, double over_M_scale, double over_q_scale) {
  std::fill_n(t.entries, (t.n + 2) * t.length(), 0.0);
  for (Index j = 0; j < t.n; ++j) {
    double* const column = t.column(j);
    for (Index i = 0; i < t.n; ++i) column[i] = problem.M(i, j) * over_M_scale;
    t.column(t.n)[j] = 1.0;
    t.right_side()[j] = problem.q[j] * over_q_scale;
    t.basis[j] = j;
    t.column_of[j] = -1;
    t.column_of[t.n + j] = j;
  }
  t.column_of[t.artificial()] = t.n;
}

/// Brings the variable `entering` into the basis, in place of that of row `r`: row r is solved for it and substituted
/// into the others.
void pivot(const Dictionary& t, Index r, Index entering) {
  const Index length = t.length();
  const Index c = t.column_of[entering];
  double* const pivot_column = t.column(c);
  const double inverse = 1.0 / pivot_column[r];
  pivot_column[r] = 0.0;
  for (Index j = 0; j < t.n + 2; ++j) {
    if (j == c) continue;
    double* const column = t.column(j);
    const double factor = -inverse * column[r];
    for (Index i = 0; i < length; i += kBlock) block(column, i) += factor * block(pivot_column, i);
    column[r] = factor;
  }
  for (Index i = 0; i < length; i += kBlock) block(pivot_column, i) *= inverse;
  pivot_column[r] = inverse;

  t.column_of[t.basis[r]] = c;
  t.column_of[entering] = -1;
  t.basis[r] = entering;
}

bool is_less(double a, double b) { return a + kTie * (1.0 + std::abs(a)) < b; }

/// Returns entry (i, j) of B^-1: the change of row i's variable by q_j. Out of the basis w_j has the same effect with
/// the opposite sign; in it, only w_j changes.
double inverse_entry(const Dictionary& t, Index i, Index j) {
  const Index column = t.column_of[j];
  if (column >= 0) return -t.column(column)[i];
  return t.basis[i] == j ? 1.0 : 0.0;
}

/// Applies the lexicographic rule: of rows with equal ratio, the one whose row of B^-1 over its pivot entry is less.
bool is_lexicographically_less(const Dictionary& t, Index a, Index b, const double* falling) {
  for (Index j = 0; j < t.n; ++j) {
    const double ratio_a = inverse_entry(t, a, j) / -falling[a];
    const double ratio_b = inverse_entry(t, b, j) / -falling[b];
    if (is_less(ratio_a, ratio_b)) return true;
    if (is_less(ratio_b, ratio_a)) return false;
  }
  return false;
}

/// Returns the row that first stops the growth of `entering`, or -1 if none does: a ray.
Index leaving_row(const Dictionary& t, Index entering) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double* const column = t.column(t.column_of[entering]);
  double* const right_side = t.right_side();
  Block largest = Block::Ones();
  for (Index i = 0; i < t.length(); i += kBlock) largest = largest.max(block(column, i).abs());
  const double zero = kZeroPivot * largest.maxCoeff();

  // Growth of `entering` at which the variable of each row is zero.
  double* const room = t.scratch;
  Block block_least = Block::Constant(kInfinity);
  for (Index i = 0; i < t.length(); i += kBlock) {
    const auto falling = block(column, i);
    block(room, i) = (falling < -zero).select(block(right_side, i) / -falling, kInfinity);
    block_least = block_least.min(block(room, i));
  }
  const double least = block_least.minCoeff();
  if (std::isinf(least)) return -1;

  Index leaving = -1;
  for (Index i = 0; i < t.n; ++i) {
    if (is_less(least, room[i])) continue;
    // Without the artificial variable the problem is solved: it goes first.
    if (t.basis[i] == t.artificial()) return i;
    if (leaving < 0 || is_lexicographically_less(t, i, leaving, column)) leaving = i;
  }
  return leaving;
}

/// Returns the remaining artificial variable; at zero the basis is a solution.
double artificial_value(const Dictionary& t) {
  const Index* const row = std::find(t.basis, t.basis + t.n, t.artificial());
  return row == t.basis + t.n ? 0.0 : t.right_side()[row - t.basis];
}

void read_solution(const Dictionary& t, double scale, Eigen::Ref<Eigen::VectorXd> z) {
  z.setZero();
  for (Index i = 0; i < t.n; ++i) {
    const Index variable = t.basis[i];
    // Rounding may have taken a zero below zero.
    if (variable >= t.n && variable < t.artificial()) z[variable - t.n] = scale * std::max(0.0, t.right_side()[i]);
  }
}

/// Returns the change of z as `entering`, which no row stops, grows; scaled to a largest entry of 1.
void read_ray(const Dictionary& t, Index entering, Eigen::Ref<Eigen::VectorXd> z) {
  z.setZero();
  if (entering >= t.n) z[entering - t.n] = 1.0;
  for (Index i = 0; i < t.n; ++i) {
    const Index variable = t.basis[i];
    if (variable >= t.n && variable < t.artificial())
      z[variable - t.n] = std::max(0.0, t.column(t.column_of[entering])[i]);
  }
  const double largest = z.maxCoeff();
  if (largest > 0.0) z /= largest;
}

/// Tests whether z solves the problem itself, and not only the dictionary after many pivots.
bool is_solution(const LcpProblem& problem, double M_scale, double q_scale, const VectorRef& z, double* w) {
  const Index n = problem.q.size();
  const double w_tolerance = kTrust * (q_scale + M_scale * z.sum());
  std::copy_n(problem.q.data(), n, w);
  for (Index j = 0; j < n; ++j) {
    if (z[j] == 0.0) continue;
    for (Index i = 0; i < n; ++i) w[i] += z[j] * problem.M(i, j);
  }
  for (Index i = 0; i < n; ++i) {
    if (!(w[i] >= -w_tolerance && (z[i] == 0.0 || w[i] <= w_tolerance))) return false;
  }
  return true;
}

/// Tests whether z >= 0 proves that no y >= 0 has M y + q >= 0: M'z <= 0 and q.z < 0, while z.(M y + q) would have to
/// be >= 0. Rounding of M'z allows only for y far beyond the problem's own size.
bool is_infeasibility_certificate(const LcpProblem& problem, double M_scale, double q_scale, const VectorRef& z) {
  double left = 0.0;
  for (Index j = 0; j < problem.q.size(); ++j) {
    const double pushed = problem.M.col(j).dot(z);
    if (pushed > kProof * M_scale * z.sum()) return false;
    left += std::max(0.0, pushed);
  }
  return -problem.q.dot(z) > kBeyond * (q_scale / M_scale) * left;
}

}  // namespace

LcpWorkspace::LcpWorkspace(Index capacity)
    : dictionary((capacity + 2) * column_length(capacity)),
      scratch(column_length(capacity)),
      basis(capacity),
      column_of(2 * capacity + 1) {}

LcpReport solve_lcp(const LcpProblem& problem, int max_pivots, LcpWorkspace& work,
                    Eigen::Ref<Eigen::VectorXd> z) noexcept {
  const MatrixRef& M = problem.M;
  const VectorRef& q = problem.q;
  const Index n = q.size();
  assert(n <= work.capacity() && M.rows() == n && M.cols() == n && z.size() == n);
  z.setZero();
  if (n == 0) return {LcpStatus::kSolved, 0};
  const double M_largest = M.cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
  const double q_largest = q.cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
  if (!std::isfinite(M_largest) || !std::isfinite(q_largest)) return {LcpStatus::kBudgetSpent, 0};
  if (q.minCoeff() >= 0.0) return {LcpStatus::kSolved, 0};

  const double M_scale = power_of_two(M_largest);
  const double q_scale = power_of_two(q_largest);
  const Dictionary t{n, work.dictionary.data(), work.scratch.data(), work.basis.data(), work.column_of.data()};
  fill(t, problem, 1.0 / M_scale, 1.0 / q_scale);

  // The artificial variable enters where the right side is least, which makes all right sides positive. Among equals
  // the last row is the lexicographically least.
  Index row = 0;
  for (Index i = 1; i < n; ++i) row = q[i] <= q[row] ? i : row;
  Index entering = t.artificial();

  LcpReport report{LcpStatus::kBudgetSpent, 0};
  bool is_ray = false;
  while (report.pivots < max_pivots && !is_ray) {
    const Index leaving = t.basis[row];
    pivot(t, row, entering);
    ++report.pivots;
    if (leaving == t.artificial()) break;
    entering = t.complement(leaving);
    row = leaving_row(t, entering);
    is_ray = row < 0;
  }

  // On a degenerate problem the artificial variable can stay in the basis, at zero.
  if (artificial_value(t) <= kTie) {
    read_solution(t, q_scale / M_scale, z);
    if (is_solution(problem, M_scale, q_scale, z, work.scratch.data())) report.status = LcpStatus::kSolved;
  } else if (is_ray) {
    read_ray(t, entering, z);
    if (is_infeasibility_certificate(problem, M_scale, q_scale, z)) report.status = LcpStatus::kInfeasible;
  }
  if (report.status == LcpStatus::kBudgetSpent) z.setZero();
  return report;
}

}  // namespace thenar
