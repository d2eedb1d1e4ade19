// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "solvers/muscles/muscle_forces.h"

namespace thenar {

/// Largest number of fingers, and of joints of one finger, in a stiffness problem.
inline constexpr int kMaxStiffFingers = 8;
inline constexpr int kMaxStiffJoints = 5;

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix6Xd = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Terms of a further unknown, the internal force s: tau + s tau_1 and so on.
struct StiffSqueeze {
  Eigen::VectorXd tau;            ///< tau_1
  Matrix6d A = Matrix6d::Zero();  ///< A_1
  Matrix6Xd B;                    ///< B_1
  Eigen::MatrixXd D;              ///< D_1; only its blocks of one finger count.
  double low = 0.0, high = 0.0;   ///< low <= s <= high
  double weight = 1.0;            ///< w > 0 of its effort 1/2 w s^2.
};

/// Least muscle effort under an object stiffness:
///     min 1/2 f'f,  H f = tau,  0 <= f <= limit,  K_o(f) >= K_des,  D_k + M_k(f) >= kappa I for each finger k,
///     M_k(f) = sum_j s_j(f_j) a_kj a_kj' - f_j G_kj,   s_j(f) = f / (1/fibre_j + f/tendon_j),
///     K_o(f) = A - sum_k B_k (D_k + M_k(f))^-1 B_k'.
/// Fingers follow each other in the rows of H, `joints[k]` rows each; a_kj are those rows of `arm`. `turn` has the
/// lower triangles of the symmetric G_kj by rows, (0,0), (1,0), (1,1), (2,0) .., one finger below the other, a column a
/// muscle. Rows 0 to 2 of the six are translation, 3 to 5 rotation.
/// A view: the numbers are owned elsewhere.
struct StiffMuscleProblem {
  using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;
  using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

  MatrixRef H;                    ///< Moment arms, joints x muscles [m].
  VectorRef tau;                  ///< Torques of the joints [N m].
  VectorRef limit;                ///< Largest forces [N], may be infinite; empty: no limits.
  std::span<const int> joints;    ///< Joints of each finger, 1 to kMaxStiffJoints; their sum is the rows of H.
  MatrixRef arm;                  ///< a_kj, joints x muscles [m].
  MatrixRef turn;                 ///< G_kj, derivatives of arms by joints, pairs of joints x muscles [m].
  VectorRef fibre_per_m;          ///< Stiffness of the fibres per newton of force, gamma / L_j, > 0 [1/m].
  VectorRef tendon_N_per_m;       ///< Stiffness of the tendons, may be infinite; empty: all infinite.
  const Matrix6d& A;              ///< [N/m], [N m/rad]
  Eigen::Ref<const Matrix6Xd> B;  ///< 6 x joints.
  MatrixRef D;                    ///< joints x joints [N m/rad]; only its blocks of one finger count.
  const Matrix6d& K_des;
  double kappa = 0.0;  ///< Least stiffness of a posture [N m/rad].
  const StiffSqueeze* squeeze = nullptr;
  double length_m = 0.025;  ///< The arm that scales rotations to translations.
};

/// A stiff muscle problem that owns its numbers.
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
    return {H,           tau,
            limit,       joints,
            arm,         turn,
            fibre_per_m, tendon_N_per_m,
            A,           B,
            D,           K_des,
            kappa,       squeeze ? &*squeeze : nullptr,
            length_m};
  }
};

/// The cause of an infeasible problem.
enum class StiffCause { kNone, kTorques, kPosture, kStiffness };

/// A symmetric matrix of one finger's joints; the leading part is used.
using FingerMatrix = Eigen::Matrix<double, kMaxStiffJoints, kMaxStiffJoints>;

struct StiffMuscleReport {
  MuscleStatus status = MuscleStatus::kBudgetSpent;
  StiffCause cause = StiffCause::kNone;
  int iterations = 0;  ///< Planes and bounds added or dropped, and Newton steps.
  /// Error of the answer [no unit]: stiff_kkt_error of an optimum, else stiff_infeasibility_gap.
  double residual = std::numeric_limits<double>::infinity();
  double squeeze = 0.0;  ///< s
  /// Certificate of the answer. Optimal: f = clamp(H'l + <Z, dK_o/df> + sum_k <Y_k, dM_k/df>, 0, limit), with Z of K_o
  /// >= K_des and Y_k of the postures positive semidefinite and complementary. Infeasible: these are weights of the
  /// conditions, with motions of the joints: see stiff_infeasibility_gap.
  MuscleReport::JointVector multiplier;
  Matrix6d Z = Matrix6d::Zero();
  std::array<FingerMatrix, kMaxStiffFingers> Y;  ///< Not set where there is no such finger.
  /// Infeasible: Q_k = sum u v z_k' and R_k = sum u z_k z_k' of the object's directions v with the joints' motions z_k,
  /// where Z = sum u v v'.
  std::array<Eigen::Matrix<double, 6, kMaxStiffJoints>, kMaxStiffFingers> motion;
  std::array<FingerMatrix, kMaxStiffFingers> bend;
};

}  // namespace thenar
