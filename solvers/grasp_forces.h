#pragma once

#include <Eigen/Core>
#include <span>

#include "solvers/lcp.h"

namespace thenar {

/// The most contacts that one grasp-force problem takes (one a finger).
inline constexpr Eigen::Index kMaxGraspContacts = 8;

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Where a finger acts on the object.
struct GraspContact {
  Eigen::Vector3d point_m;  ///< Contact point, world axes.
  Eigen::Matrix3d frame;    ///< Columns n, t1, t2 in world axes; n points into the object.
};

/// Which forces to find: the least that give `wrench` inside friction pyramids, biased towards squeezing.
struct GraspProblem {
  std::span<const GraspContact> contacts;              ///< At most kMaxGraspContacts.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< The point that torques are taken about.
  Vector6d wrench = Vector6d::Zero();                  ///< W^d on the object: force [N], torque [N m], world axes.
  double friction = 0.0;                               ///< mu_c of the pyramid.
  double internal_force_N = 0.0;                       ///< lambda of eq. (13).
};

/// How a grasp-force problem ended.
enum class GraspStatus {
  kOptimal,
  kInfeasible,   ///< No forces inside the pyramids give the wrench.
  kBudgetSpent,  ///< No answer: the pivots ran out, the input was not finite, or rounding spoiled the result.
};

struct GraspReport {
  GraspStatus status = GraspStatus::kBudgetSpent;
  int pivots = 0;
};

/// Why a grasp is infeasible: the smallest forces that would have to act beside those the pyramids allow.
struct GraspDeficit {
  /// Per contact, in its frame (n, t1, t2) [N]: e of min |e|, G (f + e) = W^d, f inside the pyramids. What no forces at
  /// the contacts can give, such as a torque about the line through all of them, is left out.
  Eigen::Matrix<double, 3, kMaxGraspContacts> missing_N = Eigen::Matrix<double, 3, kMaxGraspContacts>::Zero();
  /// Least mu_c (to 1e-3) for which the wrench can be had with some squeeze; infinity if none up to 10.
  double least_friction = 0.0;
};

/// Memory of the grasp-force solves; taken once.
class GraspWorkspace {
 public:
  GraspWorkspace();

  static constexpr Eigen::Index kMaxRows = 5 * kMaxGraspContacts;
  using RowVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxRows, 1>;
  template <int columns>
  using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, columns, 0, kMaxRows, columns>;

  LcpWorkspace lcp;
  RowMatrix<3> A;  ///< Rows of eq. (10), five a contact.
  RowMatrix<6> N;  ///< N N' = A G^+ G A'.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxRows, kMaxRows> M;
  RowVector q, z;
};

/// G [6, 7]: the 6 x 3n map from contact forces (world axes) to the wrench on the object about `centre_m`.
void grasp_map(std::span<const GraspContact> contacts, const Eigen::Vector3d& centre_m, Eigen::Ref<Eigen::MatrixXd> G);

/// Finds the contact forces of eq. (15),
///     min 1/2 f'f + c'f,  G f = W^d,  A f >= 0,   c = -lambda (n_1 .. n_n),
/// as the LCP of eq. (19), by Lemke's method:
///     M = A pi A',  q = -A pi c + A G^+ W^d,  f = pi (A' z - c) + G^+ W^d,   pi = I - G^+ G.
/// A holds five rows a contact [10]. G^+ comes from the 3x3 inertia of the contact points about their centroid, by its
/// eigenvalues, so that collinear contacts and pairs (rank G = 5) are seen and their inconsistent wrenches refused.
///
/// f         Out: 3n forces on the object, world axes [N]; on failure left as it was.
/// Accuracy  1e-10 of the forces at a friction of 0.1 and more; each tenth of it costs some three digits, and below 1e-5
///           it counts as none. Without friction at all accuracy is full again.
/// Cost      an LCP of 5n rows. Does not allocate or throw.
[[nodiscard]] GraspReport solve_grasp_forces(const GraspProblem& problem, GraspWorkspace& work,
                                             Eigen::Ref<Eigen::VectorXd> f) noexcept;

/// Explains an infeasible problem in forces. For messages and tests, not for a loop.
[[nodiscard]] GraspDeficit explain_infeasible_grasp(const GraspProblem& problem);

}  // namespace thenar
