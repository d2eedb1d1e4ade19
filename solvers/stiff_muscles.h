#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "solvers/muscle_forces.h"

namespace thenar {

/// The most fingers, and joints of one finger, whose stiffness a problem has.
inline constexpr int kMaxStiffFingers = 8;
inline constexpr int kMaxFingerJoints = 5;

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix6Xd = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// What a further unknown s, the squeeze, adds to a problem: tau + s tau_1 and so on.
struct StiffSqueeze {
  Eigen::VectorXd tau;                     ///< tau_1
  Matrix6d A = Matrix6d::Zero();           ///< A_1
  Matrix6Xd B;                             ///< B_1
  Eigen::MatrixXd D;                       ///< D_1; only its blocks of one finger count.
  double low = 0.0, high = 0.0;            ///< low <= s <= high
  double weight = 1.0;                     ///< w > 0 of its effort 1/2 w s^2.
};

/// Least muscle effort under an object stiffness:
///     min 1/2 f'f,  H f = tau,  0 <= f <= limit,  K_o(f) >= K_des,  D_k + M_k(f) >= kappa I for each finger k,
///     M_k(f) = sum_j s_j(f_j) a_kj a_kj' - f_j G_kj,   s_j(f) = f / (1/fibre_j + f/tendon_j),
///     K_o(f) = A - sum_k B_k (D_k + M_k(f))^-1 B_k'.
/// Fingers follow each other in the rows of H, `joints[k]` rows each; a_kj are those rows of `arm`. `turn` has the lower
/// triangles of the symmetric G_kj by rows, (0,0), (1,0), (1,1), (2,0) .., one finger below the other, a column a
/// muscle. Rows 0 to 2 of the six are translation, 3 to 5 rotation.
/// A view: the numbers are owned elsewhere.
struct StiffMuscleProblem {
  using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;
  using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

  MatrixRef H;                      ///< Moment arms, joints x muscles [m].
  VectorRef tau;                    ///< Torques of the joints [N m].
  VectorRef limit;                  ///< Largest forces [N], may be infinite; empty: no limits.
  std::span<const int> joints;      ///< Of each finger, 1 to kMaxFingerJoints; in sum the rows of H.
  MatrixRef arm;                    ///< a_kj, joints x muscles [m].
  MatrixRef turn;                   ///< G_kj = how arms turn with the joints, pairs of joints x muscles [m].
  VectorRef fibre_per_m;            ///< Stiffness of the fibres a newton of force, gamma / L_j, > 0 [1/m].
  VectorRef tendon_N_per_m;         ///< Stiffness of the tendons, may be infinite; empty: all are.
  const Matrix6d& A;                ///< [N/m], [N m/rad]
  Eigen::Ref<const Matrix6Xd> B;    ///< 6 x joints.
  MatrixRef D;                      ///< joints x joints [N m/rad]; only its blocks of one finger count.
  const Matrix6d& K_des;
  double kappa = 0.0;               ///< Least stiffness of a posture [N m/rad].
  const StiffSqueeze* squeeze = nullptr;
  double length_m = 0.025;          ///< The arm on which rotations compare with translations.
};

/// One that owns its numbers.
struct StiffMuscleData {
  Eigen::MatrixXd H;
  Eigen::VectorXd tau;
  Eigen::VectorXd limit;
  std::vector<int> joints;
  Eigen::MatrixXd arm, turn;
  Eigen::VectorXd fibre_per_m, tendon_N_per_m;
  Matrix6d A = Matrix6d::Zero();
  Matrix6Xd B;
  Eigen::MatrixXd D;
  Matrix6d K_des = Matrix6d::Zero();
  double kappa = 0.0;
  std::optional<StiffSqueeze> squeeze = std::nullopt;
  double length_m = 0.025;

  operator StiffMuscleProblem() const {
    return {H, tau, limit, joints, arm, turn, fibre_per_m, tendon_N_per_m, A, B, D, K_des, kappa,
            squeeze ? &*squeeze : nullptr, length_m};
  }
};

/// What an infeasible problem cannot have.
enum class StiffCause { kNone, kTorques, kPosture, kStiffness };

/// Symmetric, of one finger's joints; the leading part is used.
using FingerMatrix = Eigen::Matrix<double, kMaxFingerJoints, kMaxFingerJoints>;

struct StiffMuscleReport {
  MuscleStatus status = MuscleStatus::kBudgetSpent;
  StiffCause cause = StiffCause::kNone;
  int iterations = 0;  ///< Planes and bounds taken up or dropped, and Newton steps.
  /// How far the answer is from its proof [no unit]: stiff_kkt_error of an optimum, stiff_infeasibility_gap else.
  double residual = std::numeric_limits<double>::infinity();
  double squeeze = 0.0;  ///< s
  /// What proves it. Optimal: f = clamp(H'l + <Z, dK_o/df> + sum_k <Y_k, dM_k/df>, 0, limit), with Z of K_o >= K_des
  /// and Y_k of the postures positive semidefinite and complementary. Infeasible: the same as weights of what all
  /// forces would have to fulfil, with motions of the joints: see stiff_infeasibility_gap.
  MuscleReport::JointVector multiplier;
  Matrix6d Z = Matrix6d::Zero();
  std::array<FingerMatrix, kMaxStiffFingers> Y;  ///< These, where there is no such finger, are not set.
  /// Infeasible: Q_k = sum u v z_k' and R_k = sum u z_k z_k' of the object's directions v with the joints' motions z_k,
  /// where Z = sum u v v'.
  std::array<Eigen::Matrix<double, 6, kMaxFingerJoints>, kMaxStiffFingers> motion;
  std::array<FingerMatrix, kMaxStiffFingers> bend;
};

/// What a solve leaves to the next one of a like problem; of fixed size.
struct StiffWarmStart {
  bool is_set = false;
  Eigen::Index variables = 0, joints = 0, fingers = 0;
  Eigen::Matrix<double, kMaxMuscles + 1, 1> x;  ///< Forces, then the squeeze times the root of its weight.
  Eigen::Matrix<double, kMaxJoints, 1> l;
  Matrix6d Z;      ///< On `length_m`.
  Matrix6d basis;  ///< Rows: about the eigenvectors of K_o - K_des on `length_m`.
  std::array<FingerMatrix, kMaxStiffFingers> Y;
};

/// Finds the forces by Newton's method on the conditions of an optimum, for which semidefinite matrices are projections
/// of Z - c (K_o - K_des) and bounds of H'l + ..: from the last optimum, if there is one; else from the optimum between
/// planes that touch the limits of stiffness, which a dual active set takes up as they are violated. Forces without
/// need of stiffness are those of solve_muscle_forces.
///
/// problem   At most kMaxJoints x kMaxMuscles; A, D, K_des, D_1, A_1 symmetric.
/// last      In: the last optimum. Out: this one, if it is one.
/// f         Out, muscles [N]: the optimum; on failure left as it was.
/// Cost      Does not allocate or throw; the same problem (and start) gives the same bits.
[[nodiscard]] StiffMuscleReport solve_stiff_muscles(const StiffMuscleProblem& problem,
                                                    Eigen::Ref<Eigen::VectorXd> f) noexcept;
[[nodiscard]] StiffMuscleReport solve_stiff_muscles(const StiffMuscleProblem& problem, StiffWarmStart& last,
                                                    Eigen::Ref<Eigen::VectorXd> f) noexcept;

/// The stiffness of the object, K_o(f) with the squeeze s. False, and not a number, where a posture gives way: some
/// D_k + M_k is not positive definite.
bool object_stiffness(const StiffMuscleProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& f, double squeeze,
                      Matrix6d& K_o) noexcept;

/// D_k + M_k(f) with the squeeze s.
[[nodiscard]] FingerMatrix finger_stiffness(const StiffMuscleProblem& problem, int finger,
                                            const Eigen::Ref<const Eigen::VectorXd>& f, double squeeze) noexcept;

/// How far forces, squeeze and multipliers are from the optimum [no unit], the largest of: |f - clamp(..)| and the
/// forces that the torques' errors would be, as a share of the largest force; what K_o and the postures lack, as a share
/// of K_des and kappa; what Z and Y lack to be positive, and their products with the slacks, as a share of the effort.
[[nodiscard]] double stiff_kkt_error(const StiffMuscleProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& f,
                                     const StiffMuscleReport& report) noexcept;

/// How far weights are from a proof that there are no forces. Summed with them, H f = tau, the postures' limits and
///     v'(A - K_des) v - 2 sum_k v'B_k z_k + sum_k z_k'(D_k + M_k) z_k >= 0,
/// which K_o >= K_des means for any v and z_k, say sum_j h_j(f_j) >= need with concave h_j. The gap is the most that the
/// left side can be within the limits, over the need. Below 1 it is a proof.
[[nodiscard]] double stiff_infeasibility_gap(const StiffMuscleProblem& problem,
                                             const StiffMuscleReport& report) noexcept;

/// What a proof that there are no forces says in words.
struct StiffLack {
  /// The main direction of Z, of length 1 on length_m: translation, then rotation times length_m.
  Eigen::Matrix<double, 6, 1> direction = Eigen::Matrix<double, 6, 1>::Zero();
  double lacking_N_per_m = 0.0;  ///< K_des less this times diag(1, 1, 1, length_m^2, ..) cannot be had either.
  int finger = -1;               ///< The one that gives way, if its posture is the cause.
  Eigen::Matrix<double, kMaxFingerJoints, 1> bend =
      Eigen::Matrix<double, kMaxFingerJoints, 1>::Zero();  ///< How it does, of length 1.
  double lacking_Nm_per_rad = 0.0;                         ///< kappa less this cannot be had either.
  std::uint64_t at_limit = 0;                              ///< The muscles that would need more than their limits, a bit each.
};

[[nodiscard]] StiffLack stiff_lack(const StiffMuscleProblem& problem, const StiffMuscleReport& report) noexcept;

}  // namespace thenar
