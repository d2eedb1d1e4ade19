#include "solvers/grouped_delassus.h"

#include <cmath>

namespace thenar {
namespace {

using Eigen::Index;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

/// block += J J' in the first ten columns of J: three columns of the block at a time, the sums in registers.
template <typename Jacobian, typename Block>
void add_products(const Jacobian& J, Block& block) {
  constexpr int kUsed = GroupedDelassus::kOwn + 6;
  constexpr int kLanes = 16;  // The padding of a group's rows.
  for (Index c = 0; c < block.cols(); c += 3) {
    for (Index r = 0; r < block.rows(); r += kLanes) {
      Eigen::Array<float, kLanes, 1> n = block.col(c).template segment<kLanes>(r),
                                     t1 = block.col(c + 1).template segment<kLanes>(r),
                                     t2 = block.col(c + 2).template segment<kLanes>(r);
#pragma GCC unroll 10
      for (int j = 0; j < kUsed; ++j) {
        const auto J_r = J.col(j).template segment<kLanes>(r).array();
        n += J(c, j) * J_r;
        t1 += J(c + 1, j) * J_r;
        t2 += J(c + 2, j) * J_r;
      }
      block.col(c).template segment<kLanes>(r) = n;
      block.col(c + 1).template segment<kLanes>(r) = t1;
      block.col(c + 2).template segment<kLanes>(r) = t2;
    }
  }
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
    if (W.compliance.empty()) {
      block.setZero();
    } else {
      const Eigen::MatrixXd& C = W.compliance[k];
      for (Index c = 0; c < columns; ++c) {
        const double* const from = &C(0, c);
        float* const to = &block(0, c);
        for (Index r = 0; r < columns; ++r) to[r] = scale * static_cast<float>(from[r]);
      }
      block.bottomRows(group.rows - columns).setZero();
    }
    add_products(J, block);
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
  // A register each: sums in the workspace would wait for memory at every contact.
  Eigen::Array4d common_1 = Eigen::Array4d::Zero(), common_2 = common_1;
  for (Index k = 0; k < W.groups(); ++k) {
    Eigen::Array4d own = Eigen::Array4d::Zero();
    for (Index i = W.begin[k]; i < W.begin[k + 1]; ++i) {
      if (f[3 * i] <= 0.0) continue;
      for (Index r = 3 * i; r < 3 * i + 3; ++r) {
        own += f[r] * W.J_own.row(r).transpose().array();
        common_1 += f[r] * W.J_common.row(r).head<4>().transpose().array();
        common_2 += f[r] * W.J_common.row(r).tail<4>().transpose().array();
      }
    }
    work.own_motion.col(k) = W.own_mobility * own.matrix();
  }
  common_1 *= W.common_mobility.head<4>().array();
  common_2 *= W.common_mobility.tail<4>().array();
  work.common_motion << common_1, common_2;
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
  // Products with few columns at a time: they need no memory.
  for (Index c = 0; c < W.cols(); c += 3) {
    const Eigen::Matrix<double, kPadded, 3> moved = common_mobility.asDiagonal() * J_c.middleRows<3>(c).transpose();
    W.middleCols<3>(c) = J_c.lazyProduct(moved);
  }
  for (Index k = 0; k < groups(); ++k) {
    const Index first = 3 * begin[k], rows = 3 * begin[k + 1] - first;
    if (rows == 0) continue;
    auto W_k = W.block(first, first, rows, rows);
    const auto J_k = J_own.middleRows(first, rows);
    for (Index c = 0; c < rows; c += 3) {
      const Eigen::Matrix<double, kOwn, 3> moved = own_mobility * J_k.middleRows<3>(c).transpose();
      W_k.middleCols<3>(c) += J_k.lazyProduct(moved);
    }
    if (!compliance.empty()) W_k += compliance_scale * compliance[k].topLeftCorner(rows, rows);
  }
}

}  // namespace thenar
