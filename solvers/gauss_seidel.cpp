#include "solvers/gauss_seidel.h"

#include <algorithm>
#include <cmath>

#include "solvers/residual.h"

namespace thenar {
namespace {

using Eigen::Index;
using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using VectorMap = Eigen::Ref<Eigen::VectorXd>;

bool is_valid(const MatrixRef& W, const VectorRef& delta_free, const VectorRef& mu, const VectorRef& f) {
  return (W.diagonal().array() > 0.0).all() && W.diagonal().allFinite() && delta_free.allFinite() && mu.allFinite() &&
         f.allFinite();
}

/// A force or a gap in contact rows. In numbers, not an Eigen vector: these stay in registers.
struct Rows {
  double n, t1, t2;
};

Rows rows_of(const VectorMap& v, Index i) { return {v[3 * i], v[3 * i + 1], v[3 * i + 2]}; }

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
void add_force(const MatrixRef& W, Index i, const Rows& f_i, VectorMap& delta) {
  const Index n = 3 * i;
  delta.noalias() += f_i.n * W.col(n) + f_i.t1 * W.col(n + 1) + f_i.t2 * W.col(n + 2);
}

/// delta = W f + delta_free, without the rounding that increments gather.
void recompute_gaps(const MatrixRef& W, const VectorRef& delta_free, const VectorMap& f, VectorMap& delta) {
  delta = delta_free;
  for (Index i = 0; 3 * i < f.size(); ++i) {
    const Rows f_i = rows_of(f, i);
    if (f_i.n > 0.0) add_force(W, i, f_i, delta);
  }
}

void sweep(const MatrixRef& W, const VectorRef& mu, VectorMap& f, VectorMap& delta) {
  for (Index i = 0; i < mu.size(); ++i) {
    const Rows old = rows_of(f, i);
    const Rows updated = update_force(W, i, rows_of(delta, i), mu[i], old);
    const Rows change{updated.n - old.n, updated.t1 - old.t1, updated.t2 - old.t2};
    // Most candidates of a grasp are open and stay so.
    if (change.n == 0.0 && change.t1 == 0.0 && change.t2 == 0.0) continue;
    f.segment<3>(3 * i) << updated.n, updated.t1, updated.t2;
    add_force(W, i, change, delta);
  }
}

}  // namespace

SolveReport solve_contacts(const MatrixRef& W, const VectorRef& delta_free, const VectorRef& mu,
                           const GaussSeidelSettings& settings, Eigen::Ref<Eigen::VectorXd> f,
                           Eigen::Ref<Eigen::VectorXd> delta) noexcept {
  const auto refuse = [&](int sweeps) {
    f.setZero();
    delta.setZero();
    return SolveReport{SolveStatus::kNotFinite, sweeps, 0.0};
  };
  if (!is_valid(W, delta_free, mu, f)) return refuse(0);

  const double scale_N = free_motion_force_N(W, delta_free);
  if (scale_N == 0.0) f.setZero();  // Without free motion no force is needed, and there is no scale to judge one by.
  for (Index i = 0; i < mu.size(); ++i) {
    const Rows f_i = inside_cone({std::max(0.0, f[3 * i]), f[3 * i + 1], f[3 * i + 2]}, mu[i]);
    f.segment<3>(3 * i) << f_i.n, f_i.t1, f_i.t2;
  }
  recompute_gaps(W, delta_free, f, delta);
  if (scale_N == 0.0) return {SolveStatus::kConverged, 0, 0.0};

  // A stalled sweep moves nothing and solves nothing: judge by the residual, never by the step.
  const auto residual = [&] { return natural_map_error_N(W, mu, f, delta) / scale_N; };
  SolveReport report{SolveStatus::kBudgetSpent, 0, residual()};
  bool exact = true;
  while (true) {
    if (!exact && (report.residual <= settings.tolerance || report.sweeps == settings.max_sweeps)) {
      recompute_gaps(W, delta_free, f, delta);
      report.residual = residual();
      exact = true;
    }
    if (exact && report.residual <= settings.tolerance) report.status = SolveStatus::kConverged;
    if (report.status == SolveStatus::kConverged || report.sweeps >= settings.max_sweeps) break;
    sweep(W, mu, f, delta);
    ++report.sweeps;
    report.residual = residual();
    exact = false;
  }
  // What W holds beside its diagonal is not read before, but through the gaps.
  return delta.allFinite() && f.allFinite() ? report : refuse(report.sweeps);
}

}  // namespace thenar
