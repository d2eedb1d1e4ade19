// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "thenar/eigen_layout.h"

namespace thenar {

/// Outcome of a projection.
enum class ActiveSetStatus {
  kOptimal,
  kInfeasible,   ///< No point keeps all constraints; `multiplier` proves it.
  kBudgetSpent,  ///< The changes ran out: x and the multipliers are of no use.
};

/// Result of one projection.
struct ActiveSetReport {
  ActiveSetStatus status = ActiveSetStatus::kBudgetSpent;
  int changes = 0;  ///< Constraints taken up or dropped.
};

/// A constraint a.x >= b, seen from a point x.
template <int kNonzeros>
struct Constraint {
  int id = -1;         ///< The user's name for it.
  double slack = 0.0;  ///< a.x - b
  // a by its nonzeros; an index may come twice, and a value may be 0.
  std::array<int, kNonzeros> index{};
  std::array<double, kNonzeros> value{};

  [[nodiscard]] double row_squared() const {
    double sum = 0.0;
    for (const double v : value) sum += v * v;
    return sum;
  }
};

/// A constraint with a dense row.
template <int kSize>
struct DenseConstraint {
  int id = -1;
  double slack = 0.0;
  Eigen::Array<double, kSize, 1> row;

  [[nodiscard]] double row_squared() const { return row.square().sum(); }
};

/// The constraints that hold with equality, and an orthonormal basis of their rows. Memory of a projection; no state
/// outlives a call.
template <int kSize>
struct ActiveSet {
  using Vector = Eigen::Array<double, kSize, 1>;
  using Numbers = std::array<double, kSize>;

  /// The rows of Q first, set by the user; then one vector a constraint:
  /// a_j = Q'(..) + sum_i R(i, j) basis[equalities + i].
  std::array<Vector, kSize> basis;
  int equalities = 0;
  int active = 0;
  std::array<Numbers, kSize> R;  ///< By columns; upper triangular.
  Numbers over_diagonal;         ///< 1 / R(i, i)
  /// Optimal: the constraints without slack, and u >= 0 of x = x0 + Q'(..) + sum u_j a_j. Infeasible: u >= 0 with
  /// sum u_j a_j in the span of Q, along which no x of Q x = w can have sum u_j (a_j.x - b_j) >= 0.
  std::array<int, kSize + 1> id;
  std::array<double, kSize + 1> multiplier;

  [[nodiscard]] int working() const { return equalities + active; }
};

namespace dual_active_set {

// Rounding of x and of slacks in some tens of steps, relative to the path length of x: far above 1e-16, far below any
// required accuracy of forces.
inline constexpr double kRounding = 1e-13;
// Rounding of slacks is amplified where constraints nearly coincide. This is the largest slack, relative to the same
// path length, that still counts as rounding.
inline constexpr double kMostRounding = 1e-9;
// A constraint whose row is in the span of the working ones up to this part of its length is of their combination: a
// projection leaves 1e-16, and a point that needs less would be 1e12 violations away.
inline constexpr double kDependent = 1e-12;
// The rate at which a multiplier falls, over the largest: below this it is rounding of zero.
inline constexpr double kZeroRate = 1e-12;
// A projection that shortens a row below this part leaves the rest skewed by its rounding: it is done once more.
inline constexpr double kShortened = 0.1;

/// The decomposition of a constraint's row a in the basis of the working set: a = sum d_i basis_i + z.
template <int kSize>
struct Direction {
  typename ActiveSet<kSize>::Vector z;
  double z_squared;
  typename ActiveSet<kSize>::Numbers d;
};

/// Returns a unit vector as a view of zeros with one 1, so that no load waits for a store.
template <int kSize>
typename ActiveSet<kSize>::Vector unit(int index) {
  static constexpr auto kZerosAndOne = [] {
    std::array<double, 2 * kSize - 1> numbers{};
    numbers[kSize - 1] = 1.0;
    return numbers;
  }();
  return Eigen::Map<const typename ActiveSet<kSize>::Vector>(kZerosAndOne.data() + kSize - 1 - index);
}

/// Projects a row once more if the first projection has shortened it much.
template <int kSize>
void straighten(const ActiveSet<kSize>& set, double a_squared, Direction<kSize>& s) {
  s.z_squared = s.z.square().sum();
  if (s.z_squared >= kShortened * kShortened * a_squared) return;
  for (int i = 0; i < set.working(); ++i) {
    const double rest = (s.z * set.basis[i]).sum();
    s.z -= rest * set.basis[i];
    s.d[i] += rest;
  }
  s.z_squared = s.z.square().sum();
}

template <int kSize, int kNonzeros>
void split(const ActiveSet<kSize>& set, const Constraint<kNonzeros>& constraint, double a_squared,
           Direction<kSize>& s) {
  using Vector = typename ActiveSet<kSize>::Vector;
  Vector z = constraint.value[0] * unit<kSize>(constraint.index[0]);
  for (int k = 1; k < kNonzeros; ++k) z += constraint.value[k] * unit<kSize>(constraint.index[k]);
  for (int i = 0; i < set.working(); ++i) {
    double d = constraint.value[0] * set.basis[i][constraint.index[0]];
    for (int k = 1; k < kNonzeros; ++k) d += constraint.value[k] * set.basis[i][constraint.index[k]];
    z -= d * set.basis[i];
    s.d[i] = d;
  }
  s.z = z;
  straighten(set, a_squared, s);
}

template <int kSize>
void split(const ActiveSet<kSize>& set, const DenseConstraint<kSize>& constraint, double a_squared,
           Direction<kSize>& s) {
  // All products first: they do not wait for each other.
  for (int i = 0; i < set.working(); ++i) s.d[i] = (constraint.row * set.basis[i]).sum();
  typename ActiveSet<kSize>::Vector z = constraint.row;
  for (int i = 0; i < set.working(); ++i) z -= s.d[i] * set.basis[i];
  s.z = z;
  straighten(set, a_squared, s);
}

/// Computes r = R^-1 d, the rates at which the multipliers fall as the new constraint's grows. Returns 1 + sum |r|.
template <int kSize>
double falling_rates(const ActiveSet<kSize>& set, const Direction<kSize>& s, typename ActiveSet<kSize>::Numbers& r) {
  double r_sum = 1.0;
  for (int i = set.active - 1; i >= 0; --i) {
    double rest = s.d[set.equalities + i];
    for (int j = i + 1; j < set.active; ++j) rest -= set.R[j][i] * r[j];
    r[i] = rest * set.over_diagonal[i];
    r_sum += std::abs(r[i]);
  }
  return r_sum;
}

/// Adds the constraint: its z becomes a basis vector, and R stays triangular.
template <int kSize>
void take_up(ActiveSet<kSize>& set, const Direction<kSize>& s, int id, double multiplier) {
  const double length = std::sqrt(s.z_squared);
  const double over_length = 1.0 / length;
  set.basis[set.working()] = over_length * s.z;
  set.over_diagonal[set.active] = over_length;
  auto& column = set.R[set.active];
  for (int i = 0; i < set.active; ++i) column[i] = s.d[set.equalities + i];
  column[set.active] = length;
  set.id[set.active] = id;
  set.multiplier[set.active] = multiplier;
  ++set.active;
}

/// Drops the constraint `l`: without its column R has entries below its diagonal, which plane rotations of the basis
/// eliminate. The last basis vector, which belongs to no row any more, returns to z.
template <int kSize>
void drop(ActiveSet<kSize>& set, Direction<kSize>& s, int l) {
  --set.active;
  for (int j = l; j < set.active; ++j) {
    set.R[j] = set.R[j + 1];
    set.id[j] = set.id[j + 1];
    set.multiplier[j] = set.multiplier[j + 1];
  }
  for (int i = l; i < set.active; ++i) {
    const double length = std::sqrt(set.R[i][i] * set.R[i][i] + set.R[i][i + 1] * set.R[i][i + 1]);
    const double c = set.R[i][i] / length;
    const double sn = set.R[i][i + 1] / length;
    set.over_diagonal[i] = 1.0 / length;
    for (int j = i; j < set.active; ++j) {
      const double upper = set.R[j][i];
      set.R[j][i] = c * upper + sn * set.R[j][i + 1];
      set.R[j][i + 1] = c * set.R[j][i + 1] - sn * upper;
    }
    auto& first = set.basis[set.equalities + i];
    auto& second = set.basis[set.equalities + i + 1];
    const typename ActiveSet<kSize>::Vector turned = c * first + sn * second;
    second = c * second - sn * first;
    first = turned;
    double& d_first = s.d[set.equalities + i];
    double& d_second = s.d[set.equalities + i + 1];
    const double d_turned = c * d_first + sn * d_second;
    d_second = c * d_second - sn * d_first;
    d_first = d_turned;
  }
  s.z += s.d[set.working()] * set.basis[set.working()];
  s.z_squared = s.z.square().sum();
}

/// Bounds of the rounding of x and of slacks.
struct RoundingBounds {
  double way;              ///< Bound of all values of x so far.
  double amplified = 0.0;  ///< Largest violation that was found to be rounding.
};

/// Moves x to where a violated constraint holds and adds it to the set, after dropping those whose multiplier would
/// become negative; records a violation that is only rounding. Returns false if the projection ends, with the report's
/// status: the constraints contradict one another, or the changes ran out.
template <int kSize, class Row>
bool take_up_violated(const Row& constraint, ActiveSet<kSize>& set, typename ActiveSet<kSize>::Vector& x,
                      RoundingBounds& rounding, ActiveSetReport& report) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  // About one change for each active constraint is usual, and a few times that on degenerate problems.
  constexpr int kMaxChanges = 50 + 10 * kSize;
  Direction<kSize> s;
  typename ActiveSet<kSize>::Numbers r;
  const double a_squared = constraint.row_squared();
  split(set, constraint, a_squared, s);
  double slack = constraint.slack;
  double multiplier = 0.0;
  for (;;) {
    if (++report.changes > kMaxChanges) return false;
    const double r_sum = falling_rates(set, s, r);
    const bool is_dependent = set.working() == kSize || s.z_squared <= kDependent * kDependent * a_squared;
    // The step ends where the constraint holds or the first multiplier becomes zero.
    double step = is_dependent ? kInfinity : -slack / s.z_squared;
    int blocking = -1;
    for (int j = 0; j < set.active; ++j) {
      if (set.multiplier[j] < step * r[j] && r[j] > kZeroRate * r_sum) {
        step = set.multiplier[j] / r[j];
        blocking = j;
      }
    }
    if (is_dependent && blocking < 0) {
      // Its slack is a combination of those of the active constraints, which are rounding of zero.
      if (multiplier == 0.0 && -slack <= std::min(kRounding * r_sum, kMostRounding) * rounding.way) {
        rounding.amplified = -slack;
        return true;
      }
      for (int j = 0; j < set.active; ++j) set.multiplier[j] = std::max(0.0, -r[j]);
      set.id[set.active] = constraint.id;
      set.multiplier[set.active] = 1.0;
      ++set.active;
      report.status = ActiveSetStatus::kInfeasible;
      return false;
    }
    for (int j = 0; j < set.active; ++j) set.multiplier[j] = std::max(0.0, set.multiplier[j] - step * r[j]);
    multiplier += step;
    if (!is_dependent) {
      x += step * s.z;
      slack += step * s.z_squared;
      rounding.way += step * std::sqrt(s.z_squared);
    }
    if (blocking < 0) {
      take_up(set, s, constraint.id, multiplier);
      return true;
    }
    drop(set, s, blocking);
  }
}

}  // namespace dual_active_set

/// Finds the point of a polyhedron that is nearest to x0,
///     min 1/2 |x - x0|^2,  Q x = w,  a_j.x >= b_j for all j,
/// by the dual active set method [Goldfarb and Idnani 1983] in the full space: from the nearest point of Q x = w it
/// repeatedly adds the most violated constraint and drops those whose multiplier would become negative. Each change
/// increases the distance, so no set recurs.
///
/// set          In: Q's rows, orthonormal (none of them zero), in basis[0 .. equalities). Out: see ActiveSet.
/// x            In: the point of Q x = w nearest to x0. Out: the solution.
/// scale        The magnitude of the data from which x was computed, if larger than x: it bounds the rounding of x.
/// constraints  most_violated(x, tolerance) returns one with slack < -tolerance if there is any, best that of least
///              slack. All rows should be of like length. If x has entries of padding, Q and the rows are zero there.
/// resume       Continues with the set and x of the last call, with further constraints.
/// Accuracy     slacks and equations to about 1e-13 of the path length of x; worse where constraints nearly coincide.
/// Cost         (working + 2) kSize multiply-adds a change, and a scan for each constraint taken up. Does not allocate
///              or throw; the same problem gives the same bits.
template <int kSize, class Constraints>
[[nodiscard]] ActiveSetReport project(Constraints&& constraints, ActiveSet<kSize>& set,
                                      typename ActiveSet<kSize>::Vector& x, double scale = 0.0,
                                      bool resume = false) noexcept {
  using namespace dual_active_set;
  ActiveSetReport report;
  if (!resume) set.active = 0;
  RoundingBounds rounding{.way = std::max(scale, std::sqrt(x.square().sum()))};
  for (;;) {
    const double tolerance = std::max(kRounding * rounding.way, rounding.amplified);
    const auto constraint = constraints.most_violated(x, tolerance);
    // Comparisons with NaN are false.
    if (!std::isfinite(tolerance) || !std::isfinite(constraint.slack)) return report;
    if (constraint.slack >= -tolerance) {
      report.status = ActiveSetStatus::kOptimal;
      return report;
    }
    if (!take_up_violated(constraint, set, x, rounding, report)) return report;
  }
}

}  // namespace thenar
