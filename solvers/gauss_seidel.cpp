// SPDX-License-Identifier: Apache-2.0
#include "solvers/gauss_seidel.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/natural_map.h"
#include "solvers/residual.h"

namespace thenar {
namespace {

using Eigen::Index;
using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

LocalStep step_of(const MatrixRef& W, Index i) {
  const Index n = 3 * i;
  return local_step(W(n, n), W(n + 1, n), W(n + 2, n), W(n + 1, n + 1), W(n + 2, n + 2));
}

/// Adds the columns of contact i times a force to delta in one pass. W's rows are not read, so that it need not be
/// symmetric to the last digit.
void add_force(const MatrixRef& W, Index i, const Rows& f, VectorOut delta) {
  delta.noalias() += f.n * W.col(3 * i) + f.t1 * W.col(3 * i + 1) + f.t2 * W.col(3 * i + 2);
}

void gaps(const ContactProblem& problem, const VectorRef& f, VectorOut delta) {
  delta = problem.delta_free;
  for (Index i = 0; 3 * i < f.size(); ++i) {
    const Rows f_i = rows_of(f, i);
    if (f_i.n > 0.0) add_force(problem.W, i, f_i, delta);
  }
}

// Single precision goes from 1e-38 to 3e38. W itself has room in it between these;
constexpr double kSmallestW = 1e-20, kLargestW = 1e20;
// gaps and forces have it together with their squares, which the acceleration sums.
constexpr double kSmallestSquared = 1e-15, kLargestSquared = 1e15;

/// Tests whether single precision can represent the problem, its forces and their squares. False for NaN.
bool fits_single(const ContactProblem& problem, const VectorRef& f) {
  if (f.size() == 0) return true;
  const auto is_between = [](double low, double x, double high) { return x >= low && x <= high; };
  return is_between(kSmallestW, problem.W.diagonal().maxCoeff(), kLargestW) &&
         is_between(kSmallestSquared, problem.delta_free.cwiseAbs().maxCoeff(), kLargestSquared) &&
         is_between(kSmallestSquared, residual_scale_N(problem), kLargestSquared) &&
         f.cwiseAbs().maxCoeff() <= kLargestSquared;
}

}  // namespace

SolveReport solve_contacts(const ContactProblem& problem, const GaussSeidelSettings& settings,
                           ContactSolution solution) noexcept {
  const MatrixRef& W = problem.W;
  const VectorRef& mu = problem.mu;
  VectorOut &f = solution.f, &delta = solution.delta;
  const auto local = [&](Index i) { return step_of(W, i); };
  const Admission admission = admit(local, problem, f);
  const bool still = admission.scale_N == 0.0;
  if (!std::isfinite(admission.scale_N)) return not_finite(0, solution);
  if (still) f.setZero();
  gaps(problem, f, delta);
  const SolveStatus solved = admission.no_solution ? SolveStatus::kNoSolution : SolveStatus::kConverged;
  if (still) return {solved};

  Residual residual;
  const auto look = [&] {
    residual = {};
    for (Index i = 0; i < mu.size(); ++i) {
      const double rho = rho_of_trace(W(3 * i, 3 * i) + W(3 * i + 1, 3 * i + 1) + W(3 * i + 2, 3 * i + 2));
      const double error = natural_map_error_squared(rho, mu[i], rows_of(f, i), rows_of(delta, i));
      residual.norm += error;
      residual.worst = std::max(residual.worst, error);
    }
    residual = {std::sqrt(residual.norm) / admission.scale_N, std::sqrt(residual.worst) / admission.scale_N};
  };
  SolveReport report{SolveStatus::kBudgetSpent};
  look();
  const double stop_at = settings.stop_at(residual.norm);
  // A stalled sweep moves nothing and solves nothing: judge by the residual, never by the step.
  while (residual.norm > stop_at && report.sweeps < settings.max_sweeps) {
    for (Index i = 0; i < mu.size(); ++i) {
      const Rows old = rows_of(f, i);
      const Rows updated = update_force(local(i), mu[i], rows_of(delta, i), old);
      const Rows change{updated.n - old.n, updated.t1 - old.t1, updated.t2 - old.t2};
      // Most candidates of a grasp are open and stay so.
      if (change.n == 0.0 && change.t1 == 0.0 && change.t2 == 0.0) continue;
      set_rows(f, i, updated);
      add_force(W, i, change, delta);
    }
    ++report.sweeps;
    look();
    // Increments gather rounding.
    if (residual.norm <= stop_at || report.sweeps == settings.max_sweeps) {
      gaps(problem, f, delta);
      look();
    }
  }
  // Entries of W off its diagonal were not checked before: errors in them show here.
  if (!std::isfinite(residual.norm) || !delta.allFinite() || !f.allFinite()) return not_finite(report.sweeps, solution);
  report.residual = residual.norm;
  report.residual_worst = residual.worst;
  if (residual.norm <= settings.tolerance) report.status = solved;
  return report;
}

SolveReport solve_contacts(const ContactProblem& problem, const GaussSeidelSettings& settings, SweepWorkspace& work,
                           ContactSolution solution) noexcept {
  if (!fits_single(problem, solution.f)) return solve_contacts(problem, settings, solution);
  const MatrixRef& W = problem.W;
  const Index n = problem.mu.size();
  work.lay_out(std::array<Index, 2>{0, n});
  work.coupled = false;
  for (Index i = 0; i < n; ++i) work.local[i] = step_of(W, i);
  auto block = work.block(work.groups.front());
  // The first gaps are computed before the first sweep, from all of W: the block is made of its columns on the way.
  bool filled = false;
  const auto exact = [&](const VectorRef& forces, VectorOut out) {
    if (filled) return gaps(problem, forces, out);
    filled = true;
    out = problem.delta_free;
    for (Index i = 0; i < n; ++i) {
      auto columns = block.middleCols<3>(3 * i);
      columns.topRows(3 * n) = W.middleCols<3>(3 * i).cast<float>();
      columns.bottomRows(block.rows() - 3 * n).setZero();
      const Rows f_i = rows_of(forces, i);
      if (f_i.n > 0.0) add_force(W, i, f_i, out);
    }
  };
  return iterate_sweeps(problem, settings, work, exact, solution);
}

}  // namespace thenar
