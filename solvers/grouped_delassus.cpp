#include "solvers/grouped_delassus.h"

#include <cmath>

namespace thenar {
namespace {

using Eigen::Index;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

/// J_i' f of one contact.
template <typename Jacobian>
Eigen::Matrix<double, Jacobian::ColsAtCompileTime, 1> pull(const Jacobian& J, Index i, const Rows& f) {
  return (f.n * J.row(3 * i) + f.t1 * J.row(3 * i + 1) + f.t2 * J.row(3 * i + 2)).transpose();
}

LocalStep step_of(const GroupedDelassus& W, Index k, Index i) {
  Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
  const auto J_own = W.J_own.middleRows<3>(3 * i);
  const auto J_common = W.J_common.middleRows<3>(3 * i);
  block.noalias() += W.own_mobility * J_own.lazyProduct(J_own.transpose());
  block.noalias() += (J_common * W.common_mobility.asDiagonal()).lazyProduct(J_common.transpose());
  if (!W.compliance.empty()) {
    const Index c = 3 * (i - W.begin[k]);
    block += W.compliance_scale * W.compliance[k].block<3, 3>(c, c);
  }
  return local_step(block(0, 0), block(1, 0), block(2, 0), block(1, 1), block(2, 2));
}

/// The problem as sweeps see it. The Jacobians take the roots of the mobilities: each group's block is J J' + s C.
void fill(const GroupedDelassus& W, SweepWorkspace& work) {
  work.lay_out(W.begin);
  work.coupled = true;
  const float own_root = static_cast<float>(std::sqrt(W.own_mobility));
  const SweepWorkspace::Common common_root = W.common_mobility.cwiseSqrt().cast<float>();
  for (Index k = 0; k < W.groups(); ++k) {
    const SweepWorkspace::Group& group = work.groups[k];
    const Index first = 3 * group.begin, columns = 3 * (group.end - group.begin);
    auto J_own = work.J_own.middleRows(group.row, group.rows);
    auto J_common = work.J_common.middleRows(group.row, group.rows);
    J_own.topRows(columns) = own_root * W.J_own.middleRows(first, columns).cast<float>();
    J_common.topRows(columns) = W.J_common.middleRows(first, columns).cast<float>() * common_root.asDiagonal();
    J_own.bottomRows(group.rows - columns).setZero();
    J_common.bottomRows(group.rows - columns).setZero();
    auto block = work.block(group);
    const auto J_c = J_common.leftCols<6>();
    block.noalias() =
        J_own.lazyProduct(J_own.topRows(columns).transpose()) + J_c.lazyProduct(J_c.topRows(columns).transpose());
    if (!W.compliance.empty()) {
      block.topRows(columns) += (W.compliance_scale * W.compliance[k].topLeftCorner(columns, columns)).cast<float>();
    }
    for (Index i = group.begin; i < group.end; ++i) work.local[i] = step_of(W, k, i);
  }
}

/// The bodies' motion by forces f, and from it and the compliance the gaps.
void gaps(const GroupedDelassus& W, const VectorRef& delta_free, const VectorRef& f, GroupedWorkspace& work,
          VectorOut delta) {
  work.own_motion.setZero();
  work.common_motion.setZero();
  for (Index k = 0; k < W.groups(); ++k) {
    for (Index i = W.begin[k]; i < W.begin[k + 1]; ++i) {
      const Rows f_i = rows_of(f, i);
      if (f_i.n <= 0.0) continue;
      work.own_motion.col(k) += W.own_mobility * pull(W.J_own, i, f_i);
      work.common_motion += W.common_mobility.cwiseProduct(pull(W.J_common, i, f_i));
    }
  }
  for (Index k = 0; k < W.groups(); ++k) {
    const Index first = 3 * W.begin[k], rows = 3 * W.begin[k + 1] - first;
    auto delta_k = delta.segment(first, rows);
    delta_k = delta_free.segment(first, rows);
    delta_k.noalias() += W.J_own.middleRows(first, rows).lazyProduct(work.own_motion.col(k));
    delta_k.noalias() += W.J_common.middleRows(first, rows).lazyProduct(work.common_motion);
    if (W.compliance.empty()) continue;
    for (Index c = 0; c < rows; c += 3) {
      const Eigen::Vector3d f_i = f.segment<3>(first + c);
      if (f_i[0] <= 0.0) continue;
      delta_k.noalias() += W.compliance[k].block(0, c, rows, 3).leftCols<3>().lazyProduct(W.compliance_scale * f_i);
    }
  }
}

}  // namespace

SolveReport solve_contacts(const GroupedDelassus& W, const VectorRef& delta_free, const VectorRef& mu,
                           const GaussSeidelSettings& settings, GroupedWorkspace& work, VectorOut f,
                           VectorOut delta) noexcept {
  fill(W, work.sweeps);
  const auto exact = [&](const VectorRef& forces, VectorOut out) { gaps(W, delta_free, forces, work, out); };
  const SolveReport report = iterate_sweeps(delta_free, mu, settings, work.sweeps, exact, f, delta);
  if (report.status == SolveStatus::kNotFinite) {
    work.own_motion.setZero();
    work.common_motion.setZero();
  }
  return report;
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
