// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>

#include "solvers/lcp.h"

namespace thenar {

/// Size of the largest muscle problem.
inline constexpr Eigen::Index kMaxJoints = 32;
inline constexpr Eigen::Index kMaxMuscles = 64;

/// A muscle-force problem, eq. (23),
///     min f'f,  H f = tau,  0 <= f <= limit.
/// A view: the numbers are owned elsewhere.
struct MuscleProblem {
  Eigen::Ref<const Eigen::MatrixXd> H;    ///< Moment arms, joints x muscles [m].
  Eigen::Ref<const Eigen::VectorXd> tau;  ///< Torques of the joints [N m].
  /// Each muscle's largest force [N], 0 or more, may be infinite; empty: no muscle has a limit.
  Eigen::Ref<const Eigen::VectorXd> limit = Eigen::Map<const Eigen::VectorXd>(nullptr, 0);

  [[nodiscard]] double limit_of(Eigen::Index muscle) const {
    return limit.size() > 0 ? limit[muscle] : std::numeric_limits<double>::infinity();
  }
};

/// A muscle-force problem that owns its numbers.
struct MuscleData {
  Eigen::MatrixXd H;
  Eigen::VectorXd tau;
  Eigen::VectorXd limit = {};  ///< May be empty.

  operator MuscleProblem() const { return {H, tau, limit}; }
};

/// Outcome of a muscle-force problem.
enum class MuscleStatus {
  kOptimal,
  kInfeasible,   ///< No pulling forces within the limits give the torques.
  kBudgetSpent,  ///< No answer: the changes ran out, the input was not finite, or rounding spoiled the result.
};

struct MuscleReport {
  using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;

  MuscleStatus status = MuscleStatus::kBudgetSpent;
  int iterations = 0;  ///< Muscles made idle or active again; Lemke's method: pivots.
  /// Error of the answer [no unit]: muscle_kkt_error of an optimum, else muscle_infeasibility_gap.
  double residual = std::numeric_limits<double>::infinity();
  /// Certificate of the answer. Optimal: the multiplier l of H f = tau [N/m], with f = clamp(H' l, 0, limit).
  /// Infeasible: joint velocities l at which the torques do more work than pulling muscles can.
  JointVector multiplier;
};

/// Finds muscle forces by a dual active set [Goldfarb and Idnani 1983], in blocks: joints that share no muscle are
/// separate problems, found from the zeros of H in every call (in the hand: thumb 4 x 8, index and major 8 x 15,
/// coupled by one muscle). A row that depends on others is left out if its torque agrees with theirs, else the problem
/// is infeasible. Limits are checked only where no muscle pushes: limits that do not bind change no bit.
///
/// problem   At most kMaxJoints x kMaxMuscles.
/// f         Out, muscles [N]: the optimum; on failure unchanged.
/// Accuracy  forces and torques to about 1e-14 of their size times the condition of H's rows.
/// Cost      about muscles x joints multiply-adds a change. Does not allocate or throw; the same problem gives the same
///           bits.
[[nodiscard]] MuscleReport solve_muscle_forces(const MuscleProblem& problem, Eigen::Ref<Eigen::VectorXd> f) noexcept;

/// Memory of muscle forces by Lemke's method for up to `joints` x `muscles`, each with a limit; allocated once.
class MuscleWorkspace {
 public:
  MuscleWorkspace(Eigen::Index joints, Eigen::Index muscles);

  LcpWorkspace lcp;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> Y;  ///< Orthonormal rows that span those of H.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> L;  ///< H = L Y.
  Eigen::VectorXd t;                                                         ///< Y f = t is H f = tau.
  Eigen::MatrixXd pi;
  Eigen::VectorXd least;  ///< H^+ tau, the least forces of either sign.
  Eigen::VectorXd z;
  Eigen::MatrixXd M;  ///< M, q and zy: the LCP with limits.
  Eigen::VectorXd q;
  Eigen::VectorXd zy;
};

/// Finds muscle forces by the paper's method, the LCP of the grasp forces: with pi = I - H^+ H,
///     0 <= f = pi z + H^+ tau  _|_  z >= 0.
/// Finite limits are further rows: f = pi (z - y) + H^+ tau, 0 <= limit - f _|_ y >= 0.
/// Cost      an LCP of one row a muscle, and one a limit.
[[nodiscard]] MuscleReport solve_muscle_forces_by_lemke(const MuscleProblem& problem, MuscleWorkspace& work,
                                                        Eigen::Ref<Eigen::VectorXd> f) noexcept;

/// Computes the KKT error of forces f with a multiplier l, relative to the largest force: the largest of |f_j -
/// clamp((H' l)_j, 0, limit_j)| and of each joint's torque error divided by its longest arm, |H_i f - tau_i| / max_j
/// |H_ij|. Zero at the optimum, and there only.
[[nodiscard]] double muscle_kkt_error(const MuscleProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& l,
                                      const Eigen::Ref<const Eigen::VectorXd>& f) noexcept;

/// Computes the error of joint velocities l as a proof that no forces give the torques: the largest work of pulling
/// muscles over that of the torques, sum limit_j max(0, (H' l)_j) / tau.l. A muscle without a limit must not pull along
/// l at all; rounding in H' l counts as zero. A value below 1 is a proof; infinity if tau.l <= 0.
[[nodiscard]] double muscle_infeasibility_gap(const MuscleProblem& problem,
                                              const Eigen::Ref<const Eigen::VectorXd>& l) noexcept;

/// The muscle whose force is most insufficient.
struct MuscleLack {
  int muscle = -1;  ///< -1: no muscle pulls along the proof's velocities, however strong.
  /// Least force that it would need while all others pull with their limits; infinite if there is no muscle.
  double needed_N = std::numeric_limits<double>::infinity();
};

/// Finds the muscle that is too weak from a proof that no forces give the torques, joint velocities l: it has the
/// largest part limit_j (H' l)_j of the work.
[[nodiscard]] MuscleLack muscle_lack(const MuscleProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& l) noexcept;

}  // namespace thenar
