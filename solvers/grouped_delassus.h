#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "solvers/contact_sweeps.h"
#include "solvers/gauss_seidel.h"

namespace thenar {

/// A Delassus operator in factors, for contacts in groups, as fingers make them on one object. A group moves a body of
/// its own with 4 degrees of freedom and, with all others, a common body with 6; and it may give way by a compliance
/// among its own contacts:
///     W = J_own m_own J_own' + J_common M_common J_common' + s C,    J_own and C block diagonal by group,
///     C_ij = k_ij B_i B_j',    k_ij a scalar, B_i 3 x 3.
/// It refers to its parts.
struct GroupedDelassus {
  static constexpr int kOwn = 4;
  static constexpr int kPadded = 8;  ///< Columns of J_common: 6, and two of zeros, so that rows fill whole registers.
  using OwnJacobian = Eigen::Matrix<double, Eigen::Dynamic, kOwn, Eigen::RowMajor>;
  using CommonJacobian = Eigen::Matrix<double, Eigen::Dynamic, kPadded, Eigen::RowMajor>;
  using CommonMotion = Eigen::Matrix<double, kPadded, 1>;
  using Tensors = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

  std::span<const Eigen::Index> begin;          ///< Group k has contacts begin[k] .. begin[k + 1).
  const OwnJacobian& J_own;                     ///< 3n x 4, or more rows: of the contact's own body.
  const CommonJacobian& J_common;               ///< 3n x 6, padded.
  double own_mobility = 0.0;                    ///< m_own, the same for every group.
  CommonMotion common_mobility;                 ///< The diagonal of M_common, padded.
  std::span<const Eigen::MatrixXd> kernel;      ///< k of each group, in the leading part; empty: no compliance.
  const Tensors& tensors;                       ///< B_i, one below the other, 3n x 3 or more rows.
  double compliance_scale = 1.0;                ///< s.

  [[nodiscard]] Eigen::Index groups() const { return std::ssize(begin) - 1; }
  [[nodiscard]] Eigen::Index contacts() const { return begin.back(); }
  /// W as one matrix, 3n x 3n. Does not allocate.
  void to_dense(Eigen::Ref<Eigen::MatrixXd> W) const;
};

/// W += s C among contacts first .. first + n - 1, C_ij = k_ij B_i B_j' with the kernel's leading n x n part; W has 3n rows
/// and columns. Does not allocate.
void add_compliance(const Eigen::MatrixXd& kernel, const GroupedDelassus::Tensors& tensors, Eigen::Index first,
                    double scale, Eigen::Ref<Eigen::MatrixXd> W);

/// What a solve with a GroupedDelassus works in, for up to `contacts` contacts in `groups` groups; and the motion of the
/// bodies by the forces that it found.
struct GroupedWorkspace {
  GroupedWorkspace(Eigen::Index contacts, Eigen::Index groups)
      : sweeps(contacts, groups),
        own_motion(GroupedDelassus::kOwn, groups),
        tensors(3 * contacts + SweepWorkspace::kPadding, 3),
        kernel_column(3 * contacts + SweepWorkspace::kPadding),
        kernel_sum(contacts, 3) {}

  SweepWorkspace sweeps;
  Eigen::Matrix<double, GroupedDelassus::kOwn, Eigen::Dynamic> own_motion;  ///< Out: m_own J_own' f, a column a group.
  GroupedDelassus::CommonMotion common_motion;                              ///< Out: M_common J_common' f, padded.
  Eigen::Matrix<float, Eigen::Dynamic, 3> tensors;  ///< B of the group whose block is made, padded with zeros.
  Eigen::VectorXf kernel_column;                    ///< s k_ij for one j, three times each.
  Eigen::Matrix<double, Eigen::Dynamic, 3> kernel_sum;  ///< sum_j k_ij B_j' f_j of a group.
};

/// As solve_contacts with a dense W, and no W to form: the Jacobians may be new in every call. Each group's own block of W
/// is made in single precision, 14 multiply-adds an entry, and swept; groups move one another through the common body.
/// Cost      With m contacts a group, 9 m n multiply-adds a sweep.
[[nodiscard]] SolveReport solve_contacts(const GroupedDelassus& W, const Eigen::Ref<const Eigen::VectorXd>& delta_free,
                                         const Eigen::Ref<const Eigen::VectorXd>& mu,
                                         const GaussSeidelSettings& settings, GroupedWorkspace& work,
                                         Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<Eigen::VectorXd> delta) noexcept;

}  // namespace thenar
