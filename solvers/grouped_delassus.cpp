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

/// The problem as sweeps see it. The Jacobians take the roots of the mobilities: each group's block is J J' + s C.
void fill(const GroupedDelassus& W, SweepWorkspace& work) {
  work.lay_out(W.begin);
  work.coupled = true;
  constexpr int kOwn = GroupedDelassus::kOwn, kCommon = GroupedDelassus::kPadded;
  const float scale = static_cast<float>(W.compliance_scale);
  const float own_root = static_cast<float>(std::sqrt(W.own_mobility));
  const Eigen::Matrix<float, kCommon, 1> common_root = W.common_mobility.cwiseSqrt().cast<float>();
  for (Index k = 0; k < W.groups(); ++k) {
    const SweepWorkspace::Group& group = work.groups[k];
    const Index first = 3 * group.begin, columns = 3 * (group.end - group.begin);
    auto J = work.J.middleRows(group.row, group.rows);
    J.topLeftCorner(columns, kOwn) = own_root * W.J_own.middleRows(first, columns).cast<float>();
    J.topRightCorner(columns, kCommon) = W.J_common.middleRows(first, columns).cast<float>() * common_root.asDiagonal();
    J.bottomRows(group.rows - columns).setZero();
    auto block = work.block(group);
    block.noalias() = J.leftCols<kOwn + 6>() * J.topLeftCorner(columns, kOwn + 6).transpose();
    if (!W.compliance.empty()) {
      block.topRows(columns) += scale * W.compliance[k].topLeftCorner(columns, columns).cast<float>();
    }
    for (Index i = group.begin; i < group.end; ++i) {
      const Index n = 3 * (i - group.begin);
      work.local[i] =
          local_step(block(n, n), block(n + 1, n), block(n + 2, n), block(n + 1, n + 1), block(n + 2, n + 2));
    }
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
  const Eigen::Array4d common_1 = work.common_motion.head<4>().array(), common_2 = work.common_motion.tail<4>().array();
  for (Index k = 0; k < W.groups(); ++k) {
    const Index first = 3 * W.begin[k], rows = 3 * W.begin[k + 1] - first;
    const Eigen::Array4d own = work.own_motion.col(k).array();
    for (Index r = first; r < first + rows; ++r) {
      // The 12 products in three registers, which are added up once.
      const Eigen::Array4d parts = W.J_own.row(r).transpose().array() * own +
                                   W.J_common.row(r).head<4>().transpose().array() * common_1 +
                                   W.J_common.row(r).tail<4>().transpose().array() * common_2;
      delta[r] = delta_free[r] + parts.sum();
    }
    if (W.compliance.empty()) continue;
    for (Index c = 0; c < rows; c += 3) {
      const Eigen::Vector3d f_i = f.segment<3>(first + c);
      if (f_i[0] <= 0.0) continue;
      delta.segment(first, rows).noalias() +=
          W.compliance[k].block(0, c, rows, 3).leftCols<3>().lazyProduct(W.compliance_scale * f_i);
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
