#include "solvers/gauss_seidel.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/grouped_delassus.h"
#include "solvers/natural_map.h"

namespace thenar {
namespace {

using Eigen::Index;
using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using VectorOut = Eigen::Ref<Eigen::VectorXd>;
using LocalBlock = GroupedWorkspace::LocalBlock;

// Between the rounding of some hundred sweeps' increments and the residuals that are asked for in a loop.
constexpr double kRoundingMatters = 1e-10;

Rows rows_of(const VectorOut& v, Index i) { return {v[3 * i], v[3 * i + 1], v[3 * i + 2]}; }

void set_rows(VectorOut& v, Index i, const Rows& rows) {
  v[3 * i] = rows.n;
  v[3 * i + 1] = rows.t1;
  v[3 * i + 2] = rows.t2;
}

/// target += three columns times a force: one pass over the target.
template <typename Columns, typename Target>
void add_columns(const Columns& columns, const Rows& f, Target&& target) {
  target.noalias() += f.n * columns.col(0) + f.t1 * columns.col(1) + f.t2 * columns.col(2);
}

/// J_i' f of one contact.
template <typename Jacobian>
Eigen::Matrix<double, Jacobian::ColsAtCompileTime, 1> pull(const Jacobian& J, Index i, const Rows& f) {
  return (f.n * J.row(3 * i) + f.t1 * J.row(3 * i + 1) + f.t2 * J.row(3 * i + 2)).transpose();
}

/// W as one matrix. Gaps of all contacts are kept up to date.
class DenseOperator {
 public:
  DenseOperator(const MatrixRef& W, VectorOut& delta) : W_(W), delta_(delta) {}

  [[nodiscard]] LocalBlock local(Index i) const {
    const Index n = 3 * i;
    return {W_(n, n), W_(n + 1, n), W_(n + 2, n), W_(n + 1, n + 1), W_(n + 2, n + 2)};
  }
  void reset(const VectorRef& delta_free) { delta_ = delta_free; }
  [[nodiscard]] Rows gap(Index i) const { return rows_of(delta_, i); }
  void add_force(Index i, const Rows& f) { add_columns(W_.middleCols<3>(3 * i), f, delta_); }
  void write_gaps() {}

 private:
  const MatrixRef& W_;
  VectorOut& delta_;
};

/// W in factors: what is kept up to date are the bodies' motions and, of the gaps, the share of the compliance.
class GroupedOperator {
 public:
  GroupedOperator(const GroupedDelassus& W, GroupedWorkspace& work, VectorOut& delta)
      : W_(W), work_(work), delta_(delta) {
    for (Index k = 0; k < W.groups(); ++k) {
      for (Index i = W.begin[k]; i < W.begin[k + 1]; ++i) work.local[i] = block(k, i);
    }
  }

  [[nodiscard]] const LocalBlock& local(Index i) const { return work_.local[i]; }
  void reset(const VectorRef& delta_free) {
    delta_ = delta_free;
    work_.common_motion.setZero();
    work_.own_motion.setZero();
  }
  [[nodiscard]] Rows gap(Index i) {
    find_group(i);
    const auto own = work_.own_motion.col(group_);
    const auto rigid = [&](Index row) {
      return W_.J_own.row(row).dot(own) + W_.J_common.row(row).dot(work_.common_motion);
    };
    return {delta_[3 * i] + rigid(3 * i), delta_[3 * i + 1] + rigid(3 * i + 1), delta_[3 * i + 2] + rigid(3 * i + 2)};
  }
  void add_force(Index i, const Rows& f) {
    find_group(i);
    work_.own_motion.col(group_) += W_.own_mobility * pull(W_.J_own, i, f);
    work_.common_motion += W_.common_mobility.cwiseProduct(pull(W_.J_common, i, f));
    if (W_.compliance.empty()) return;
    const Index first = W_.begin[group_], count = W_.begin[group_ + 1] - first;
    const double s = W_.compliance_scale;
    add_columns(W_.compliance[group_].block(0, 3 * (i - first), 3 * count, 3), {s * f.n, s * f.t1, s * f.t2},
                delta_.segment(3 * first, 3 * count));
  }
  void write_gaps() {
    for (Index i = 0; i < W_.contacts(); ++i) set_rows(delta_, i, gap(i));
  }

 private:
  /// Contacts come in their order: their group is the last one's or a later one, or the first again.
  void find_group(Index i) {
    if (i < W_.begin[group_]) group_ = 0;
    while (i >= W_.begin[group_ + 1]) ++group_;
  }
  [[nodiscard]] LocalBlock block(Index k, Index i) const {
    const Index n = 3 * i, t1 = n + 1, t2 = n + 2;
    const auto rigid = [&](Index r, Index c) {
      return W_.own_mobility * W_.J_own.row(r).dot(W_.J_own.row(c)) +
             W_.J_common.row(r).cwiseProduct(W_.common_mobility.transpose()).dot(W_.J_common.row(c));
    };
    LocalBlock block{rigid(n, n), rigid(t1, n), rigid(t2, n), rigid(t1, t1), rigid(t2, t2)};
    if (W_.compliance.empty()) return block;
    const Index c = 3 * (i - W_.begin[k]);
    const auto C = W_.compliance[k].block<3, 3>(c, c);
    const double s = W_.compliance_scale;
    block.nn += s * C(0, 0);
    block.t1n += s * C(1, 0);
    block.t2n += s * C(2, 0);
    block.t1t1 += s * C(1, 1);
    block.t2t2 += s * C(2, 2);
    return block;
  }

  const GroupedDelassus& W_;
  GroupedWorkspace& work_;
  VectorOut& delta_;
  Index group_ = 0;
};

/// One step of a contact towards its laws, the others held: the normal force closes the gap, the tangential force
/// then undoes the slip that is left as far as friction goes. Only an exact solution stays where it is.
Rows update_force(const LocalBlock& W, const Rows& delta, double mu, const Rows& f) {
  // The reciprocals do not wait for the gap.
  const double f_n = f.n - (1.0 / W.nn) * delta.n;
  if (!(f_n > 0.0)) return {0.0, 0.0, 0.0};

  const double change = f_n - f.n;
  const double stiffness_t = 2.0 / (W.t1t1 + W.t2t2);
  const double slip_1 = delta.t1 + W.t1n * change;
  const double slip_2 = delta.t2 + W.t2n * change;
  return inside_cone({f_n, f.t1 - stiffness_t * slip_1, f.t2 - stiffness_t * slip_2}, mu);
}

/// The gaps of f, without the rounding that increments gather.
template <typename Operator>
void recompute_gaps(Operator& W, const VectorRef& delta_free, const VectorOut& f) {
  W.reset(delta_free);
  for (Index i = 0; 3 * i < f.size(); ++i) {
    const Rows f_i = rows_of(f, i);
    if (f_i.n > 0.0) W.add_force(i, f_i);
  }
}

template <typename Operator>
void sweep(Operator& W, const VectorRef& mu, VectorOut& f) {
  for (Index i = 0; i < mu.size(); ++i) {
    const Rows old = rows_of(f, i);
    const Rows updated = update_force(W.local(i), W.gap(i), mu[i], old);
    const Rows change{updated.n - old.n, updated.t1 - old.t1, updated.t2 - old.t2};
    // Most candidates of a grasp are open and stay so.
    if (change.n == 0.0 && change.t1 == 0.0 && change.t2 == 0.0) continue;
    set_rows(f, i, updated);
    W.add_force(i, change);
  }
}

double rho(const LocalBlock& W) { return 3.0 / W.trace(); }

template <typename Operator>
double error_N(Operator& W, const VectorRef& mu, const VectorOut& f) {
  double sum = 0.0;
  for (Index i = 0; i < mu.size(); ++i) {
    sum += natural_map_error_squared(rho(W.local(i)), mu[i], rows_of(f, i), W.gap(i));
  }
  return std::sqrt(sum);
}

/// The free motion's force [N], which scales the residual; NaN where the problem is not one.
template <typename Operator>
double scale_of(const Operator& W, const VectorRef& delta_free, const VectorRef& mu, const VectorOut& f) {
  double sum = 0.0;
  for (Index i = 0; i < mu.size(); ++i) {
    const LocalBlock& block = W.local(i);
    if (!(std::min({block.nn, block.t1t1, block.t2t2}) > 0.0 && std::isfinite(block.trace())))
      return std::numeric_limits<double>::quiet_NaN();
    sum += (rho(block) * delta_free.segment<3>(3 * i)).squaredNorm();
  }
  if (!mu.allFinite() || !f.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(sum);
}

template <typename Operator>
SolveReport solve(Operator& W, const VectorRef& delta_free, const VectorRef& mu, const GaussSeidelSettings& settings,
                  VectorOut& f, VectorOut& delta) {
  const auto refuse = [&](int sweeps) {
    f.setZero();
    W.reset(VectorRef(f));
    return SolveReport{SolveStatus::kNotFinite, sweeps, std::numeric_limits<double>::infinity()};
  };
  const double scale_N = scale_of(W, delta_free, mu, f);
  if (!std::isfinite(scale_N)) return refuse(0);
  if (scale_N == 0.0) {
    // Without free motion no force is needed, and there is no scale to judge one by.
    f.setZero();
    W.reset(VectorRef(f));
    return {SolveStatus::kConverged, 0, 0.0};
  }
  for (Index i = 0; i < mu.size(); ++i) {
    const Rows guess = rows_of(f, i);
    set_rows(f, i, inside_cone(guess, mu[i]));
  }
  recompute_gaps(W, delta_free, f);

  // A stalled sweep moves nothing and solves nothing: judge by the residual, never by the step. It costs a part of a
  // sweep, so looking less often would save less than the sweeps too many. Increments gather rounding, which only a
  // tolerance close to it can see.
  const bool fine = settings.tolerance < kRoundingMatters;
  const auto residual = [&] { return error_N(W, mu, f) / scale_N; };
  SolveReport report{SolveStatus::kBudgetSpent, 0, residual()};
  while (report.residual > settings.tolerance && report.sweeps < settings.max_sweeps) {
    sweep(W, mu, f);
    ++report.sweeps;
    report.residual = residual();
    if (fine && (report.residual <= settings.tolerance || report.sweeps == settings.max_sweeps)) {
      recompute_gaps(W, delta_free, f);
      report.residual = residual();
    }
  }
  W.write_gaps();
  // What W holds beside its diagonal was not looked at before: it shows here.
  if (!std::isfinite(report.residual) || !delta.allFinite() || !f.allFinite()) return refuse(report.sweeps);
  if (report.residual <= settings.tolerance) report.status = SolveStatus::kConverged;
  return report;
}

}  // namespace

SolveReport solve_contacts(const MatrixRef& W, const VectorRef& delta_free, const VectorRef& mu,
                           const GaussSeidelSettings& settings, VectorOut f, VectorOut delta) noexcept {
  DenseOperator dense(W, delta);
  return solve(dense, delta_free, mu, settings, f, delta);
}

SolveReport solve_contacts(const GroupedDelassus& W, const VectorRef& delta_free, const VectorRef& mu,
                           const GaussSeidelSettings& settings, GroupedWorkspace& work, VectorOut f,
                           VectorOut delta) noexcept {
  GroupedOperator grouped(W, work, delta);
  return solve(grouped, delta_free, mu, settings, f, delta);
}

void GroupedDelassus::to_dense(Eigen::Ref<Eigen::MatrixXd> W) const {
  const auto J_c = J_common.topRows(3 * contacts());
  W.noalias() = J_c * common_mobility.asDiagonal() * J_c.transpose();
  for (Index k = 0; k < groups(); ++k) {
    const Index first = 3 * begin[k], rows = 3 * begin[k + 1] - first;
    if (rows == 0) continue;
    auto W_k = W.block(first, first, rows, rows);
    const auto J_k = J_own.middleRows(first, rows);
    W_k.noalias() += own_mobility * J_k * J_k.transpose();
    if (!compliance.empty()) W_k += compliance_scale * compliance[k].topLeftCorner(rows, rows);
  }
}

}  // namespace thenar
