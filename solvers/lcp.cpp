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

// M and q are scaled to a largest entry of 1. What pivoting leaves of a zero is rounding of the largest entries of its
// column; the smallest entries that matter, squares of a friction of 1e-5, are about 1e-10.
constexpr double kZeroPivot = 1e-11;
constexpr double kTie = 1e-12;
// A solution must hold in the problem as given to this part of its terms, and a proof that there is none to this part
// of M: it excludes solutions up to z of 1e8. A ray is no more exact where a matrix is nearly of less rank than it has.
constexpr double kTrust = 1e-9;
constexpr double kProof = 1e-8;

/// Rows are padded to whole AVX registers.
constexpr Index row_length(Index n) { return (2 * n + 2 + 3) / 4 * 4; }

/// The equations w - M z - z0 (1..1)' = q solved for the variables in the basis. Columns are variables: w_i is i,
/// z_i is n + i, the artificial z0 is 2n; the right side comes last.
struct Tableau {
  Index n;
  double* entries;
  Index* basis;

  [[nodiscard]] Index artificial() const { return 2 * n; }
  [[nodiscard]] Index right_side() const { return 2 * n + 1; }
  [[nodiscard]] Index complement(Index variable) const { return variable < n ? variable + n : variable - n; }
  [[nodiscard]] double* row(Index i) const { return entries + i * row_length(n); }
};

void fill(const Tableau& t, const MatrixRef& M, double M_scale, const VectorRef& q, double q_scale) {
  std::fill_n(t.entries, t.n * row_length(t.n), 0.0);
  for (Index i = 0; i < t.n; ++i) {
    double* const row = t.row(i);
    row[i] = 1.0;
    for (Index j = 0; j < t.n; ++j) row[t.n + j] = -M(i, j) / M_scale;
    row[t.artificial()] = -1.0;
    row[t.right_side()] = q[i] / q_scale;
    t.basis[i] = i;
  }
}

/// Brings the variable `entering` into the basis, in place of that of row `r`.
void pivot(const Tableau& t, Index r, Index entering) {
  const Index length = row_length(t.n);
  double* const pivot_row = t.row(r);
  const double inverse = 1.0 / pivot_row[entering];
  for (Index j = 0; j < length; ++j) pivot_row[j] *= inverse;
  pivot_row[entering] = 1.0;

  for (Index i = 0; i < t.n; ++i) {
    double* const __restrict row = t.row(i);
    const double factor = row[entering];
    if (i == r || factor == 0.0) continue;
    const double* const __restrict source = pivot_row;
    for (Index j = 0; j < length; ++j) row[j] -= factor * source[j];
    row[entering] = 0.0;
  }
  t.basis[r] = entering;
}

bool is_less(double a, double b) { return a + kTie * (1.0 + std::abs(a)) < b; }

/// The lexicographic rule: of two rows with the same ratio, the one whose row of B^-1 over its pivot entry is less.
bool is_lexicographically_less(const Tableau& t, Index a, Index b, Index entering) {
  const double* const row_a = t.row(a);
  const double* const row_b = t.row(b);
  for (Index j = 0; j < t.n; ++j) {
    const double ratio_a = row_a[j] / row_a[entering];
    const double ratio_b = row_b[j] / row_b[entering];
    if (is_less(ratio_a, ratio_b)) return true;
    if (is_less(ratio_b, ratio_a)) return false;
  }
  return false;
}

/// The row that first stops the growth of `entering`, or -1 if none does: a ray.
Index leaving_row(const Tableau& t, Index entering) {
  double largest = 1.0;
  for (Index i = 0; i < t.n; ++i) largest = std::max(largest, std::abs(t.row(i)[entering]));
  const double zero = kZeroPivot * largest;
  // How far `entering` can grow until the variable of row i is zero.
  const auto room = [&](Index i) {
    const double* const row = t.row(i);
    return row[entering] > zero ? row[t.right_side()] / row[entering] : std::numeric_limits<double>::infinity();
  };

  double least = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < t.n; ++i) least = std::min(least, room(i));
  if (std::isinf(least)) return -1;

  Index leaving = -1;
  for (Index i = 0; i < t.n; ++i) {
    if (is_less(least, room(i))) continue;
    // Without the artificial variable the problem is solved: it goes first.
    if (t.basis[i] == t.artificial()) return i;
    if (leaving < 0 || is_lexicographically_less(t, i, leaving, entering)) leaving = i;
  }
  return leaving;
}

/// What is left of the artificial variable; at zero the basis is a solution.
double artificial_value(const Tableau& t) {
  const Index* const row = std::find(t.basis, t.basis + t.n, t.artificial());
  return row == t.basis + t.n ? 0.0 : t.row(row - t.basis)[t.right_side()];
}

void read_solution(const Tableau& t, double scale, Eigen::Ref<Eigen::VectorXd> z) {
  z.setZero();
  for (Index i = 0; i < t.n; ++i) {
    const Index variable = t.basis[i];
    // Rounding may have taken a zero below zero.
    if (variable >= t.n && variable < t.artificial())
      z[variable - t.n] = scale * std::max(0.0, t.row(i)[t.right_side()]);
  }
}

/// How z changes as `entering`, which no row stops, grows; scaled to a largest entry of 1.
void read_ray(const Tableau& t, Index entering, Eigen::Ref<Eigen::VectorXd> z) {
  z.setZero();
  if (entering >= t.n) z[entering - t.n] = 1.0;
  for (Index i = 0; i < t.n; ++i) {
    const Index variable = t.basis[i];
    if (variable >= t.n && variable < t.artificial()) z[variable - t.n] = std::max(0.0, -t.row(i)[entering]);
  }
  const double largest = z.maxCoeff();
  if (largest > 0.0) z /= largest;
}

/// Whether z solves the problem itself, and not only the tableau that many pivots made of it.
bool is_solution(const MatrixRef& M, double M_scale, const VectorRef& q, double q_scale, const VectorRef& z) {
  const double w_tolerance = kTrust * (q_scale + M_scale * z.sum());
  for (Index i = 0; i < q.size(); ++i) {
    const double w = M.row(i).dot(z) + q[i];
    if (w < -w_tolerance || (z[i] > 0.0 && w > w_tolerance)) return false;
  }
  return true;
}

/// Whether z >= 0 proves that no y >= 0 has M y + q >= 0: M'z <= 0 and q.z < 0, while z.(M y + q) would have to be >=
/// 0.
bool is_infeasibility_certificate(const MatrixRef& M, double M_scale, const VectorRef& q, const VectorRef& z) {
  for (Index j = 0; j < q.size(); ++j) {
    if (M.col(j).dot(z) > kProof * M_scale * z.sum()) return false;
  }
  return q.dot(z) < 0.0;
}

}  // namespace

LcpWorkspace::LcpWorkspace(Index capacity) : tableau(capacity * row_length(capacity)), basis(capacity) {}

LcpReport solve_lcp(const MatrixRef& M, const VectorRef& q, int max_pivots, LcpWorkspace& work,
                    Eigen::Ref<Eigen::VectorXd> z) noexcept {
  const Index n = q.size();
  assert(n <= work.capacity() && M.rows() == n && M.cols() == n && z.size() == n);
  z.setZero();
  if (!M.allFinite() || !q.allFinite()) return {LcpStatus::kBudgetSpent, 0};
  if (n == 0 || q.minCoeff() >= 0.0) return {LcpStatus::kSolved, 0};

  const double M_largest = M.cwiseAbs().maxCoeff();
  const double M_scale = M_largest > 0.0 ? M_largest : 1.0;
  const double q_scale = q.cwiseAbs().maxCoeff();
  const Tableau t{n, work.tableau.data(), work.basis.data()};
  fill(t, M, M_scale, q, q_scale);

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
    if (is_solution(M, M_scale, q, q_scale, z)) report.status = LcpStatus::kSolved;
  } else if (is_ray) {
    read_ray(t, entering, z);
    if (is_infeasibility_certificate(M, M_scale, q, z)) report.status = LcpStatus::kInfeasible;
  }
  if (report.status == LcpStatus::kBudgetSpent) z.setZero();
  return report;
}

}  // namespace thenar
