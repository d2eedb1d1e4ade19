// SPDX-License-Identifier: Apache-2.0
#include "solvers/contact_sweeps.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace thenar {
namespace {

using Eigen::Index;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

constexpr Index kPadding = SweepWorkspace::kPadding;
// Relative ridge of the acceleration's least squares: the accuracy that single precision leaves.
constexpr double kRidge = 1e-10;
// A change that has grown this much indicates another set of active laws: earlier results are no guide.
constexpr double kGrown = 2.0;
Index padded(Index rows) { return (rows + kPadding - 1) / kPadding * kPadding; }

using Group = SweepWorkspace::Group;

Index rows_used(const SweepWorkspace& work) {
  return work.groups.empty() ? 0 : work.groups.back().row + work.groups.back().rows;
}

/// Floats that are worked on at once: the compiler's own vectors, so that sums of many of them stay in registers.
constexpr Index kLanes = 8;
using Lanes [[gnu::vector_size(kLanes * sizeof(float))]] = float;
// Without AVX such a vector is passed in another way than with it, which GCC warns of: all who pass it are in this
// file.
#pragma GCC diagnostic ignored "-Wpsabi"

Lanes load(const float* p) {
  Lanes lanes;
  std::memcpy(&lanes, p, sizeof lanes);
  return lanes;
}

void store(const Lanes& lanes, float* p) { std::memcpy(p, &lanes, sizeof lanes); }

float sum(const Lanes& v) {
  const auto four = __builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7);
  const auto two = four + __builtin_shufflevector(four, four, 2, 3, 0, 1);
  return two[0] + two[1];
}

Rows gap_at(const double* computed, const float* moved) {
  return {computed[0] + moved[0], computed[1] + moved[1], computed[2] + moved[2]};
}

void forget(SweepWorkspace& work) {
  const Index rows = rows_used(work);
  work.d_change.topRows(rows).setZero();
  work.d_moved.topRows(rows).setZero();
  work.d_f.topRows(rows).setZero();
  work.gram.setZero();
  work.differences = 0;
  work.has_last = false;
  work.least_change = std::numeric_limits<double>::infinity();
}

using Window = Eigen::Matrix<double, SweepWorkspace::kWindow, 1>;

/// Solves A x = b for a symmetric positive definite A by elimination. Unrolled (kWindow times), it stays in registers:
/// in loops it would cost a sixth of a sweep of 15 contacts.
Window solve_definite(Eigen::Matrix<double, SweepWorkspace::kWindow, SweepWorkspace::kWindow> A, Window b) {
  constexpr int n = SweepWorkspace::kWindow;
  Window per_pivot;
#pragma GCC unroll 5
  for (int k = 0; k < n; ++k) {
    per_pivot[k] = 1.0 / A(k, k);
#pragma GCC unroll 5
    for (int j = k + 1; j < n; ++j) {
      const double factor = A(j, k) * per_pivot[k];
#pragma GCC unroll 5
      for (int i = j; i < n; ++i) A(i, j) -= factor * A(i, k);
      b[j] -= factor * b[k];
    }
  }
#pragma GCC unroll 5
  for (int k = n - 1; k >= 0; --k) {
#pragma GCC unroll 5
    for (int j = n - 1; j > k; --j) b[k] -= A(j, k) * b[j];
    b[k] *= per_pivot[k];
  }
  return b;
}

/// Stores the differences to the last result in d_change, d_moved and d_f, in place of the oldest ones.
void remember(SweepWorkspace& work, const VectorRef& f) {
  const Index rows = rows_used(work);
  const auto change = work.change.head(rows), moved = work.moved.head(rows);
  if (work.has_last) {
    const Index newest = work.differences++ % SweepWorkspace::kWindow;
    work.d_change.col(newest).head(rows) = change - work.change_last.head(rows);
    work.d_moved.col(newest).head(rows) = moved - work.moved_last.head(rows);
    for (const Group& group : work.groups) {
      const Index first = 3 * group.begin, count = 3 * (group.end - group.begin);
      work.d_f.col(newest).segment(group.row, count) =
          (f.segment(first, count) - work.f_last.segment(first, count)).cast<float>();
    }
  }
  work.change_last.head(rows) = change;
  work.moved_last.head(rows) = moved;
  work.f_last.head(f.size()) = f;
  work.has_last = true;
}

/// Updates the newest difference's row of the Gram matrix; returns the differences times the change.
Window products(SweepWorkspace& work) {
  constexpr int n = SweepWorkspace::kWindow;
  const Index rows = rows_used(work), newest = (work.differences - 1) % n;
  Lanes gram[n] = {}, right[n] = {};
  for (Index r = 0; r < rows; r += kLanes) {
    const Lanes d_newest = load(&work.d_change(r, newest)), change = load(&work.change[r]);
    for (int j = 0; j < n; ++j) {
      const Lanes d = load(&work.d_change(r, j));
      gram[j] += d * d_newest;
      right[j] += d * change;
    }
  }
  Window products;
  for (int j = 0; j < n; ++j) {
    work.gram(newest, j) = work.gram(j, newest) = sum(gram[j]);
    products[j] = sum(right[j]);
  }
  return products;
}

}  // namespace

SweepWorkspace::SweepWorkspace(Index contacts, Index groups_at_most)
    : local(contacts),
      blocks((3 * contacts + kPadding * groups_at_most) * 3 * contacts),
      common_after(kCommon, groups_at_most),
      f_last(3 * contacts) {
  const Index rows = 3 * contacts + kPadding * groups_at_most;
  groups.reserve(groups_at_most);
  for (auto* v : {&moved, &change, &change_last, &moved_last}) v->setZero(rows);
  for (auto* columns : {&d_change, &d_moved, &d_f}) columns->setZero(rows, kWindow);
  J.setZero(rows, kOwn + kCommon);
}

void SweepWorkspace::lay_out(std::span<const Index> begin, bool whole, bool body) {
  groups.clear();
  Index row = 0, block = 0;
  for (std::size_t k = 0; k + 1 < begin.size(); ++k) {
    const Index rows = padded(3 * (begin[k + 1] - begin[k]));
    groups.push_back({begin[k], begin[k + 1], row, rows, row, rows, 0});
    row += rows;
  }
  if (body) groups.push_back({begin.back(), begin.back(), row, kPadding, row, kPadding, 0});
  if (body) row += kPadding;
  for (Group& group : groups) {
    if (whole) group.first = 0, group.span = row;
    group.block = block;
    block += group.span * 3 * (group.end - group.begin);
  }
}

void start_sweeps(SweepWorkspace& work) {
  const Index rows = rows_used(work);
  work.moved.head(rows).setZero();
  work.change.head(rows).setZero();
  if (!work.goes_on) return forget(work);
  work.has_last = false;
  work.least_change = std::numeric_limits<double>::infinity();
}

void gaps_are_exact(SweepWorkspace& work) {
  const Index rows = rows_used(work);
  work.moved_last.head(rows) -= work.moved.head(rows);
  work.moved.head(rows).setZero();
}

Residual sweep_residual(const SweepWorkspace& work, const VectorRef& mu, const VectorRef& f, const VectorRef& delta,
                        double scale_N) {
  double sum = 0.0, worst = 0.0;  // squared [N^2]
  for (const Group& group : work.groups) {
    for (Index i = group.begin; i < group.end; ++i) {
      const double error = natural_map_error_squared(
          work.local[i].rho, mu[i], rows_of(f, i),
          gap_at(delta.data() + 3 * i, work.moved.data() + group.row + 3 * (i - group.begin)));
      sum += error;
      worst = std::max(worst, error);
    }
  }
  return {std::sqrt(sum) / scale_N, std::sqrt(worst) / scale_N};
}

namespace {

/// Returns the body's motion by a group's changes: J' change.
SweepWorkspace::Common common_by(const SweepWorkspace& work, const Group& group) {
  SweepWorkspace::Common common = SweepWorkspace::Common::Zero();
  for (int c = 0; c < 6; ++c) {
    Lanes products = {};
    for (Index r = group.row; r < group.row + group.rows; r += kLanes) {
      products += load(&work.change[r]) * load(&work.J(r, SweepWorkspace::kOwn + c));
    }
    common[c] = sum(products);
  }
  return common;
}

/// Moves a group's contacts with the body: J common.
void move_with(const SweepWorkspace::Common& common, const Group& group, SweepWorkspace& work) {
  for (Index r = group.row; r < group.row + group.rows; r += kLanes) {
    Lanes moved = load(&work.moved[r]);
    for (int c = 0; c < 6; ++c) moved += common[c] * load(&work.J(r, SweepWorkspace::kOwn + c));
    store(moved, &work.moved[r]);
  }
}

}  // namespace

double sweep(const VectorRef& mu, const VectorRef& delta, SweepWorkspace& work, VectorOut f) {
  const Index count = std::ssize(work.groups);
  SweepWorkspace::Common common = SweepWorkspace::Common::Zero();
  for (Index k = 0; k < count; ++k) {
    const Group& group = work.groups[k];
    const Index rows = group.span;
    const auto W = work.block(group);
    float* const moved_by = work.moved.data() + group.first;
    float* const moved = work.moved.data() + group.row;
    float* const change = work.change.data() + group.row;
    if (work.coupled && k > 0) move_with(common, group, work);
    const Index last = 3 * (group.end - group.begin - 1);
    const double* const delta_k = delta.data() + 3 * group.begin;
    const double* const mu_k = mu.data() + group.begin;
    const LocalStep* const local = work.local.data() + group.begin;
    double* const f_k = f.data() + 3 * group.begin;
    Rows gap = last < 0 ? Rows{} : gap_at(delta_k, moved);
    for (Index i = 0, r = 0; r <= last; ++i, r += 3) {
      const Rows old{f_k[r], f_k[r + 1], f_k[r + 2]};
      const Rows updated = update_force(local[i], mu_k[i], gap, old);
      const Rows step{updated.n - old.n, updated.t1 - old.t1, updated.t2 - old.t2};
      const float step_n = static_cast<float>(step.n), step_1 = static_cast<float>(step.t1),
                  step_2 = static_cast<float>(step.t2);
      change[r] = step_n, change[r + 1] = step_1, change[r + 2] = step_2;
      const Index next = std::min(r + 3, last);
      gap = gap_at(delta_k + next, moved + next);
      // Most candidates of a grasp are open and stay so.
      if (std::abs(step_n) + std::abs(step_1) + std::abs(step_2) == 0.0f) continue;
      f_k[r] = updated.n, f_k[r + 1] = updated.t1, f_k[r + 2] = updated.t2;
      const float* const W_n = W.data() + r * rows;
      const float *const W_1 = W_n + rows, *const W_2 = W_1 + rows;
      const Index at_next = group.row - group.first + next;
      // The effect on the next contact is passed in registers: it need not wait for all the others.
      gap.n += step.n * W_n[at_next] + step.t1 * W_1[at_next] + step.t2 * W_2[at_next];
      gap.t1 += step.n * W_n[at_next + 1] + step.t1 * W_1[at_next + 1] + step.t2 * W_2[at_next + 1];
      gap.t2 += step.n * W_n[at_next + 2] + step.t1 * W_1[at_next + 2] + step.t2 * W_2[at_next + 2];
      // One after the other: the normal's share does not wait for the tangents'.
      for (Index lane = 0; lane < rows; lane += kPadding) {
        float* const at = moved_by + lane;
        const Lanes first =
            load(at) + step_n * load(W_n + lane) + step_1 * load(W_1 + lane) + step_2 * load(W_2 + lane);
        const Lanes second = load(at + kLanes) + step_n * load(W_n + lane + kLanes) +
                             step_1 * load(W_1 + lane + kLanes) + step_2 * load(W_2 + lane + kLanes);
        store(first, at);
        store(second, at + kLanes);
      }
    }
    if (!work.coupled) continue;
    common += common_by(work, group);
    work.common_after.col(k) = common;
  }
  for (Index k = 0; work.coupled && k + 1 < count; ++k) {
    move_with(common - work.common_after.col(k), work.groups[k], work);
  }
  return work.change.head(rows_used(work)).norm();
}

void move_body(const SweepWorkspace::Common& motion, SweepWorkspace& work) {
  for (const Group& group : work.groups) move_with(motion, group, work);
}

void accelerate(double change_N, SweepWorkspace& work, VectorOut f) {
  if (!(change_N > 0.0)) return;
  if (change_N > kGrown * work.least_change) forget(work);
  work.least_change = std::min(work.least_change, change_N);
  remember(work, f);
  if (work.differences == 0) return;

  const Window right = products(work);
  Eigen::Matrix<double, SweepWorkspace::kWindow, SweepWorkspace::kWindow> ridged = work.gram;
  // Columns without a difference yet are zero, and so are their weights.
  const double ridge = kRidge * work.gram.trace();
  for (Index j = 0; j < SweepWorkspace::kWindow; ++j)
    ridged(j, j) = work.gram(j, j) > 0.0 ? work.gram(j, j) + ridge : 1.0;
  const Window weights = solve_definite(ridged, right);
  if (!std::isfinite(weights.sum())) return;

  // The next sweep takes into their cones what this leaves outside.
  for (const Group& group : work.groups) {
    const Index count = 3 * (group.end - group.begin);
    double* const f_group = f.data() + 3 * group.begin;
    for (Index r = 0; r < group.rows; r += kLanes) {
      Lanes moved = {}, df = {};
      for (int j = 0; j < SweepWorkspace::kWindow; ++j) {
        const float weight = static_cast<float>(weights[j]);
        moved += weight * load(&work.d_moved(group.row + r, j));
        df += weight * load(&work.d_f(group.row + r, j));
      }
      store(load(&work.moved[group.row + r]) - moved, &work.moved[group.row + r]);
      for (Index i = 0; i < std::min(kLanes, count - r); ++i) f_group[r + i] -= df[i];
    }
  }
}

}  // namespace thenar
