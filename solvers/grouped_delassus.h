// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "solvers/contact_problem.h"
#include "solvers/contact_sweeps.h"
#include "solvers/ground_contacts.h"

namespace thenar {

/// The compliance of a surface: its displacement at contacts i by forces at contacts j of one group. In contact rows,
/// with the axes E_i = (n_i, t_i1, t_i2), D = diag(0, 1, 1) and r_ij = p_i - p_j:
///     C_ij = k_ij E_i' E_j + D (a_ij E_i' E_j + b_ij E_i' r_ij r_ij' E_j) D.
/// The first term is the same in all directions; the second, of a half space, makes the tangential compliance depend on
/// direction [Cerruti 1882].
class SurfaceCompliance {
 public:
  /// Allocates for up to `contacts` contacts and starts with none.
  explicit SurfaceCompliance(Eigen::Index contacts = 0);

  struct Entry {
    double k, a, b;  ///< [m/N], [m/N], [1/(N m)]
  };
  /// Sets the entries of contacts i < `contacts` and j. The entries of i, j and of j, i must be equal.
  template <typename EntryOf>
  void set_column(Eigen::Index j, Eigen::Index contacts, EntryOf entry_of) {
    double *const k_j = k.col(j).data(), *const a_j = a.col(j).data(), *const b_j = b.col(j).data();
    float *normal = normal_rows.col(j).data(), *cross = cross_rows.col(j).data(), *bent = bent_rows.col(j).data();
    for (Eigen::Index i = 0; i < contacts; ++i, normal += 3, cross += 3, bent += 3) {
      const Entry entry = entry_of(i);
      k_j[i] = entry.k, a_j[i] = entry.a, b_j[i] = entry.b;
      normal[0] = normal[1] = normal[2] = cross[0] = static_cast<float>(entry.k);
      cross[1] = cross[2] = static_cast<float>(entry.k + entry.a);
      bent[0] = 0.0F, bent[1] = bent[2] = static_cast<float>(entry.b);
    }
  }
  [[nodiscard]] Eigen::Matrix3d entry(Eigen::Index i, Eigen::Index j, const Eigen::Matrix3d& E_i,
                                      const Eigen::Matrix3d& E_j) const;
  [[nodiscard]] bool is_finite(Eigen::Index contacts) const;

  Eigen::MatrixX3d p_m;     ///< p_i, in the frame of the axes.
  Eigen::MatrixXd k, a, b;  ///< Entries, in the leading part.
  /// Factors of the block's rows in single precision, three a contact: k; k + a, tangential; b, tangential.
  Eigen::MatrixXf normal_rows, cross_rows, bent_rows;
};

/// The compliance of the common body's surface at contacts i under forces at contacts j, of all groups:
///     C_ij = s k_ij T_i T_j'.
/// A view; without parts the body is rigid.
struct SharedCompliance {
  const Eigen::MatrixXd* k = nullptr;                                            ///< n x n, or more [m/N].
  const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>* T = nullptr;  ///< T_i, in contact rows: 3n x 3.
  double scale = 1.0;                                                            ///< s.

  [[nodiscard]] explicit operator bool() const { return k != nullptr; }
};

/// A Delassus operator in factors, for contacts in groups, as fingers make them on one object. A group moves a body of
/// its own with up to 5 degrees of freedom and, with all others, a common body with 6; and it may have a compliance
/// among its own contacts:
///     W = J_own m_own J_own' + J_common M_common J_common' + s C + C_common,    J_own and C block diagonal by group.
/// A view of its parts.
struct GroupedDelassus {
  static constexpr int kOwn = 4;
  static constexpr int kPadded = 8;  ///< Columns of J_common: 6, and two of zeros, so that rows fill whole registers.
  using OwnJacobian = Eigen::Matrix<double, Eigen::Dynamic, kOwn, Eigen::RowMajor>;
  using CommonJacobian = Eigen::Matrix<double, Eigen::Dynamic, kPadded, Eigen::RowMajor>;
  using CommonMotion = Eigen::Matrix<double, kPadded, 1>;
  using Axes = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

  std::span<const Eigen::Index> begin;  ///< Group k has contacts begin[k] .. begin[k + 1).
  const OwnJacobian& J_own;             ///< Jacobian of the contact's own body, 3n x 4, or more rows.
  const Eigen::VectorXd& J_fifth;       ///< Fifth column of J_own; empty: no body has a fifth degree of freedom.
  const CommonJacobian& J_common;       ///< 3n x 6, padded.
  double own_mobility = 0.0;            ///< m_own, the same for every group.
  CommonMotion common_mobility;         ///< The diagonal of M_common, padded.
  std::span<const SurfaceCompliance> compliance;  ///< Compliance of each group; empty: none.
  const Axes& axes;                               ///< Rows E_i', 3n x 3 or more rows.
  double compliance_scale = 1.0;                  ///< s.
  std::span<const double> group_scale = {};       ///< Factor of s for each group; empty: 1.
  SharedCompliance common_compliance = {};
  std::int64_t list = -1;     ///< Equal in calls with the same contacts; < 0: unlike any other.
  std::int64_t edition = -1;  ///< Equal in calls with the same contacts and compliance; < 0: unlike any other.

  [[nodiscard]] Eigen::Index groups() const { return std::ssize(begin) - 1; }
  [[nodiscard]] double scale(Eigen::Index k) const {
    return group_scale.empty() ? compliance_scale : compliance_scale * group_scale[k];
  }
  [[nodiscard]] Eigen::Index contacts() const { return begin.back(); }
  /// Writes W as one matrix, 3n x 3n. Does not allocate.
  void to_dense(Eigen::Ref<Eigen::MatrixXd> W) const;
};

/// Contacts of the common body with the ground. Its mobility is that of the operator.
struct CommonGround {
  GroundProblem problem;
  GroundProblem::Motion x_free;  ///< The body's motion without any contact.
};

/// A ContactProblem whose W is in factors.
struct GroupedContactProblem {
  GroupedDelassus W;
  Eigen::Ref<const Eigen::VectorXd> delta_free;  ///< Gaps and slips by the body's free motion [m].
  Eigen::Ref<const Eigen::VectorXd> mu;
  const CommonGround* ground = nullptr;  ///< Null: the body does not touch the ground.
};

/// Adds s C among contacts first .. first + n - 1 to W, which has 3n rows and columns. Does not allocate.
void add_compliance(const SurfaceCompliance& compliance, const GroupedDelassus::Axes& axes, Eigen::Index first,
                    double scale, Eigen::Ref<Eigen::MatrixXd> W);

/// Adds the C of W's contacts to W, which has three rows and columns of each. Does not allocate.
void add_compliance(const SharedCompliance& compliance, Eigen::Ref<Eigen::MatrixXd> W);

/// A force at a contact in the form of the sums of C f, in the frame of the axes.
struct SurfaceLoad {
  Eigen::Index contact;  ///< Index in its group.
  Eigen::Vector3d f, g;  ///< The force, and its tangential part.
  Eigen::Vector3d p;
  double p_g;
};

/// Memory of solves with a GroupedDelassus for up to `contacts` contacts in `groups` groups; and the motion of bodies
/// and surfaces by the forces found.
struct GroupedWorkspace {
  static constexpr int kMostOwn = GroupedDelassus::kOwn + 1;
  using OwnMotion = Eigen::Matrix<double, kMostOwn, Eigen::Dynamic>;

  /// Allocates. shared: the common body may be compliant. ground_contacts: its most contacts with the ground.
  GroupedWorkspace(Eigen::Index contacts, Eigen::Index groups, bool shared = false, Eigen::Index ground_contacts = 0)
      : sweeps(contacts, groups + (ground_contacts > 0 ? 1 : 0)),
        own_motion(OwnMotion::Zero(kMostOwn, groups)),
        surface_motion(3 * contacts),
        axes(3 * contacts + SweepWorkspace::kPadding, 3),
        points(3 * contacts + SweepWorkspace::kPadding, 3),
        heights(3 * contacts + SweepWorkspace::kPadding),
        J_then(sweeps.J),
        ground(ground_contacts) {
    loads.reserve(contacts);
    shared_motion.setZero(shared ? 3 * contacts : 0);
    shared_sums.setZero(shared ? contacts : 0, 3);
    tensors.setZero(shared ? sweeps.J.rows() : 0, 3);
    shared_rows.setZero(tensors.rows());
  }

  SweepWorkspace sweeps;
  OwnMotion own_motion;                         ///< Out: m_own J_own' f, a column a group.
  GroupedDelassus::CommonMotion common_motion;  ///< Out: M_common J_common' f, padded, with the ground's effect.
  Eigen::VectorXd surface_motion;               ///< Out if groups have a compliance: s C f, 3n rows or more.
  Eigen::VectorXd shared_motion;                ///< Out if the common body is compliant: C_common f, 3n rows or more.
  // E', p and E' p of the group whose block is made, three rows a contact and padded with zeros.
  Eigen::Matrix<float, Eigen::Dynamic, 3> axes, points;
  Eigen::VectorXf heights;
  std::vector<SurfaceLoad> loads;
  // For a compliant common body: T times the root of its scale and k_ij of one j, in the groups' rows; sums.
  Eigen::Matrix<float, Eigen::Dynamic, 3> tensors;
  Eigen::VectorXf shared_rows;
  Eigen::MatrixX3d shared_sums;
  std::int64_t list = -1;     // Contacts of the last sweeps.
  std::int64_t edition = -1;  // Edition of which the blocks were made.
  double compliance_scale = 0.0;
  decltype(SweepWorkspace::J) J_then;
  float J_then_most = 0.0F;  // Its largest entry, without the rows of the common body itself.
  GroundWorkspace ground;    ///< Out if there is a ground: its forces, and the body's motion.
  // (M^-1 + J' K J)^-1 = L L' of the body on the ground, L = R^-T; its motion when gaps were last computed.
  Eigen::Matrix<double, 6, 6> R, L;
  GroundProblem::Motion x_exact;
  int linearisations = 0;
  double ground_missing = 0.0;
  SolveStatus ground_status = SolveStatus::kConverged;
};

/// Computes the motion by forces f (3n): own, common, surface and shared motion of `work`, without the ground. Contacts
/// without a normal force count as unloaded. Does not allocate.
void find_motion(const GroupedDelassus& W, const Eigen::Ref<const Eigen::VectorXd>& f, GroupedWorkspace& work);

/// Solves a contact problem as solve_contacts does with a dense W, without forming W: the Jacobians may change in every
/// call. Each group's own block of W is made in single precision, 14 multiply-adds an entry, and swept; groups are
/// coupled by the common body. Where that is compliant, blocks have whole columns, 9 multiply-adds an entry. While W's
/// edition lasts, and its Jacobians hardly change, blocks are kept from call to call; while its list lasts, what sweeps
/// have learned.
/// A ground is eliminated: in the sweeps the body has the mobility that its ground contacts leave, and after each sweep
/// it is moved to where the ground's laws hold exactly under the groups' forces: see solve_ground.
/// Cost      With m contacts a group, 9 m n multiply-adds a sweep; where the common body is compliant, 9 n^2.
[[nodiscard]] SolveReport solve_contacts(const GroupedContactProblem& problem, const GaussSeidelSettings& settings,
                                         GroupedWorkspace& work, ContactSolution solution) noexcept;

}  // namespace thenar
