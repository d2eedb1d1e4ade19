#include "solvers/grouped_delassus.h"

#include <cmath>

namespace thenar {
namespace {

using Eigen::Index;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

constexpr Index kLanes = SweepWorkspace::kPadding;
using Lanes = Eigen::Array<float, kLanes, 1>;

/// The three columns of contact j from `c` on of J J' and, with a compliance, of k_ij B_i B_j': the sums in registers.
template <bool kCompliant, typename Jacobian, typename Block>
void fill_columns(const Jacobian& J, const GroupedWorkspace& work, Index c, Block& block) {
  constexpr int kUsed = GroupedDelassus::kOwn + 6;
  const auto& B = work.tensors;
  for (Index r = 0; r < block.rows(); r += kLanes) {
    Lanes n = Lanes::Zero(), t1 = n, t2 = n;
    if constexpr (kCompliant) {
#pragma GCC unroll 3
      for (int j = 0; j < 3; ++j) {
        const auto B_r = B.col(j).template segment<kLanes>(r).array();
        n += B(c, j) * B_r;
        t1 += B(c + 1, j) * B_r;
        t2 += B(c + 2, j) * B_r;
      }
      const auto k = work.kernel_column.segment<kLanes>(r).array();
      n *= k;
      t1 *= k;
      t2 *= k;
    }
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

/// A group's block, J J' + s C.
template <typename Jacobian, typename Block>
void fill_block(const GroupedDelassus& W, Index k, const Jacobian& J, GroupedWorkspace& work, Block& block) {
  if (W.kernel.empty()) {
    for (Index c = 0; c < block.cols(); c += 3) fill_columns<false>(J, work, c, block);
    return;
  }
  const Index columns = block.cols(), padding = block.rows() - columns;
  work.tensors.topRows(columns) = W.tensors.middleRows(3 * W.begin[k], columns).cast<float>();
  work.tensors.middleRows(columns, padding).setZero();
  work.kernel_column.segment(columns, padding).setZero();
  for (Index j = 0; 3 * j < columns; ++j) {
    const double* const kernel = &W.kernel[k](0, j);
    float* const column = work.kernel_column.data();
    for (Index i = 0; 3 * i < columns; ++i) {
      column[3 * i] = column[3 * i + 1] = column[3 * i + 2] = static_cast<float>(W.compliance_scale * kernel[i]);
    }
    fill_columns<true>(J, work, 3 * j, block);
  }
}

/// The problem as sweeps see it. The Jacobians take the roots of the mobilities: each group's block is J J' + s C.
void fill(const GroupedDelassus& W, GroupedWorkspace& grouped) {
  SweepWorkspace& work = grouped.sweeps;
  work.lay_out(W.begin);
  work.coupled = true;
  constexpr int kOwn = GroupedDelassus::kOwn, kCommon = GroupedDelassus::kPadded;
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
    fill_block(W, k, J, grouped, block);
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
    if (W.kernel.empty()) continue;
    auto sum = work.kernel_sum.topRows(W.begin[k + 1] - W.begin[k]);
    sum.setZero();
    for (Index j = W.begin[k]; j < W.begin[k + 1]; ++j) {
      const Eigen::Vector3d f_j = f.segment<3>(3 * j);
      if (f_j[0] <= 0.0) continue;
      const Eigen::Vector3d w_j = W.tensors.middleRows<3>(3 * j).transpose() * f_j;
      const auto k_j = W.kernel[k].col(j - W.begin[k]).head(sum.rows());
      for (int axis = 0; axis < 3; ++axis) sum.col(axis) += w_j[axis] * k_j;
    }
    for (Index i = 0; i < sum.rows(); ++i) {
      delta.segment<3>(first + 3 * i) +=
          W.compliance_scale * (W.tensors.middleRows<3>(first + 3 * i) * sum.row(i).transpose());
    }
  }
}

}  // namespace

SolveReport solve_contacts(const GroupedDelassus& W, const VectorRef& delta_free, const VectorRef& mu,
                           const GaussSeidelSettings& settings, GroupedWorkspace& work, VectorOut f,
                           VectorOut delta) noexcept {
  fill(W, work);
  const auto exact = [&](const VectorRef& forces, VectorOut out) { gaps(W, delta_free, forces, work, out); };
  const SolveReport report = iterate_sweeps(delta_free, mu, settings, work.sweeps, exact, f, delta);
  if (report.status == SolveStatus::kNotFinite) {
    work.own_motion.setZero();
    work.common_motion.setZero();
  }
  return report;
}

void add_compliance(const Eigen::MatrixXd& kernel, const GroupedDelassus::Tensors& tensors, Index first, double scale,
                    Eigen::Ref<Eigen::MatrixXd> W) {
  for (Index j = 0; 3 * j < W.cols(); ++j) {
    const Eigen::Matrix3d B_j = scale * tensors.middleRows<3>(3 * (first + j)).transpose();
    for (Index i = 0; 3 * i < W.rows(); ++i) {
      W.block<3, 3>(3 * i, 3 * j) += kernel(i, j) * (tensors.middleRows<3>(3 * (first + i)) * B_j);
    }
  }
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
    if (!kernel.empty()) add_compliance(kernel[k], tensors, begin[k], compliance_scale, W_k);
  }
}

}  // namespace thenar
