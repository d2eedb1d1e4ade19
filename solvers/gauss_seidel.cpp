#include "solvers/gauss_seidel.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/residual.h"

namespace thenar {
namespace {

using Eigen::Index;
using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

bool is_valid(const MatrixRef& W, const VectorRef& delta_free, const VectorRef& mu, const VectorRef& f) {
  return (W.diagonal().array() > 0.0).all() && W.diagonal().allFinite() && delta_free.allFinite() && mu.allFinite() &&
         f.allFinite();
}

/// A force or a gap in contact rows. In numbers, not an Eigen vector: these stay in registers.
struct Rows {
  double n, t1, t2;
};

Rows rows_of(const VectorOut& v, Index i) { return {v[3 * i], v[3 * i + 1], v[3 * i + 2]}; }

void set_rows(VectorOut& v, Index i, const Rows& rows) {
  v[3 * i] = rows.n;
  v[3 * i + 1] = rows.t1;
  v[3 * i + 2] = rows.t2;
}

/// Scales the tangential force back to the cone.
Rows inside_cone(const Rows& f, double mu) {
  const double limit = mu * f.n;
  const double squared = f.t1 * f.t1 + f.t2 * f.t2;
  if (squared <= limit * limit) return f;
  const double scale = limit / std::sqrt(squared);
  return {f.n, scale * f.t1, scale * f.t2};
}

/// One step of contact i towards its laws, the others held: the normal force closes the gap, the tangential force
/// then undoes the slip that is left as far as friction goes. Only an exact solution stays where it is.
Rows update_force(const MatrixRef& W, Index i, const Rows& delta, double mu, const Rows& f) {
  const Index n = 3 * i;
  const Index t1 = n + 1;
  const Index t2 = n + 2;
  // The reciprocals do not wait for the gap.
  const double f_n = f.n - (1.0 / W(n, n)) * delta.n;
  if (f_n <= 0.0) return {0.0, 0.0, 0.0};

  const double change = f_n - f.n;
  const double stiffness_t = 2.0 / (W(t1, t1) + W(t2, t2));
  const double slip_1 = delta.t1 + W(t1, n) * change;
  const double slip_2 = delta.t2 + W(t2, n) * change;
  return inside_cone({f_n, f.t1 - stiffness_t * slip_1, f.t2 - stiffness_t * slip_2}, mu);
}

/// delta += W times a force at contact i. One pass over delta: three columns of W at a time.
void add_force(const MatrixRef& W, Index i, const Rows& f_i, VectorOut& delta) {
  const Index n = 3 * i;
  delta.noalias() += f_i.n * W.col(n) + f_i.t1 * W.col(n + 1) + f_i.t2 * W.col(n + 2);
}

/// delta = W f + delta_free, without the rounding that increments gather.
void recompute_gaps(const MatrixRef& W, const VectorRef& delta_free, const VectorOut& f, VectorOut& delta) {
  delta = delta_free;
  for (Index i = 0; 3 * i < f.size(); ++i) {
    const Rows f_i = rows_of(f, i);
    if (f_i.n > 0.0) add_force(W, i, f_i, delta);
  }
}

void sweep(const MatrixRef& W, const VectorRef& mu, VectorOut& f, VectorOut& delta) {
  for (Index i = 0; i < mu.size(); ++i) {
    const Rows old = rows_of(f, i);
    const Rows updated = update_force(W, i, rows_of(delta, i), mu[i], old);
    const Rows change{updated.n - old.n, updated.t1 - old.t1, updated.t2 - old.t2};
    // Most candidates of a grasp are open and stay so.
    if (change.n == 0.0 && change.t1 == 0.0 && change.t2 == 0.0) continue;
    set_rows(f, i, updated);
    add_force(W, i, change, delta);
  }
}

}  // namespace

SolveReport solve_contacts(const MatrixRef& W, const VectorRef& delta_free, const VectorRef& mu,
                           const GaussSeidelSettings& settings, VectorOut f, VectorOut delta) noexcept {
  const auto refuse = [&](int sweeps) {
    f.setZero();
    delta.setZero();
    return SolveReport{SolveStatus::kNotFinite, sweeps, std::numeric_limits<double>::infinity()};
  };
  if (!is_valid(W, delta_free, mu, f)) return refuse(0);

  const double scale_N = free_motion_force_N(W, delta_free);
  if (scale_N == 0.0) {
    // Without free motion no force is needed, and there is no scale to judge one by.
    f.setZero();
    delta.setZero();
    return {SolveStatus::kConverged, 0, 0.0};
  }
  for (Index i = 0; i < mu.size(); ++i) {
    const Rows guess = rows_of(f, i);
    set_rows(f, i, inside_cone({std::max(0.0, guess.n), guess.t1, guess.t2}, mu[i]));
  }
  recompute_gaps(W, delta_free, f, delta);

  // A stalled sweep moves nothing and solves nothing: judge by the residual, never by the step. It costs a seventh of a
  // sweep, so looking less often would save less than the sweeps too many.
  const auto residual = [&] { return natural_map_error_N(W, mu, f, delta) / scale_N; };
  SolveReport report{SolveStatus::kBudgetSpent, 0, residual()};
  while (report.residual > settings.tolerance && report.sweeps < settings.max_sweeps) {
    sweep(W, mu, f, delta);
    ++report.sweeps;
    report.residual = residual();
    if (report.residual <= settings.tolerance || report.sweeps == settings.max_sweeps) {
      recompute_gaps(W, delta_free, f, delta);
      report.residual = residual();
    }
  }
  // What W holds beside its diagonal was not looked at before: it shows here.
  if (!std::isfinite(report.residual) || !delta.allFinite() || !f.allFinite()) return refuse(report.sweeps);
  if (report.residual <= settings.tolerance) report.status = SolveStatus::kConverged;
  return report;
}

}  // namespace thenar
