#pragma once

#include <Eigen/Core>
#include <limits>

#include "solvers/lcp.h"

namespace thenar {

/// The largest muscle problem.
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

/// One that owns its numbers.
struct MuscleData {
  Eigen::MatrixXd H;
  Eigen::VectorXd tau;
  Eigen::VectorXd limit = {};  ///< May be empty.

  operator MuscleProblem() const { return {H, tau, limit}; }
};

/// How a muscle-force problem ended.
enum class MuscleStatus {
  kOptimal,
  kInfeasible,   ///< No pulling forces within the limits give the torques.
  kBudgetSpent,  ///< No answer: the changes ran out, the input was not finite, or rounding spoiled the result.
};

struct MuscleReport {
  using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;

  MuscleStatus status = MuscleStatus::kBudgetSpent;
  int iterations = 0;  ///< Muscles laid idle or taken up again; of Lemke's method pivots.
  /// How far the answer is from its proof [no unit]: muscle_kkt_error of an optimum, muscle_infeasibility_gap else.
  double residual = std::numeric_limits<double>::infinity();
  /// What proves it. Optimal: the multiplier l of H f = tau [N/m], with f = clamp(H' l, 0, limit).
  /// Infeasible: joint velocities l at which the torques do more work than pulling muscles can.
  JointVector multiplier;
};

/// Finds muscle forces by a dual active set [Goldfarb and Idnani 1983], in blocks: joints that share no muscle are
/// problems of their own, and are found from the zeros of H in every call (of the hand thumb 4 x 8, index and major 8 x
/// 15, coupled by one muscle). A row that depends on others is left out if its torque agrees with theirs, else there
/// are no such forces. Limits are looked at where no muscle pushes: those that do not bind change no bit.
///
/// problem   At most kMaxJoints x kMaxMuscles.
/// f         Out, muscles [N]: the optimum; on failure left as it was.
/// Accuracy  forces and torques to about 1e-14 of their size times the condition of H's rows.
/// Cost      about muscles x joints multiply-adds a change. Does not allocate or throw; the same problem gives the same
///           bits.
[[nodiscard]] MuscleReport solve_muscle_forces(const MuscleProblem& problem, Eigen::Ref<Eigen::VectorXd> f) noexcept;

/// Memory of muscle forces by Lemke's method for up to `joints` x `muscles`, of which so many have limits; taken once.
class MuscleWorkspace {
 public:
  MuscleWorkspace(Eigen::Index joints, Eigen::Index muscles, Eigen::Index limits = 0);

  LcpWorkspace lcp;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> Y;  ///< Orthonormal rows that span those of H.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> L;  ///< H = L Y.
  Eigen::VectorXd t;                                                         ///< Y f = t is H f = tau.
  Eigen::MatrixXd pi;
  Eigen::VectorXd least;  ///< H^+ tau, the least forces of either sign.
  Eigen::VectorXd z;
  Eigen::MatrixXd M;  ///< This to zy: of the LCP with limits.
  Eigen::VectorXd q;
  Eigen::VectorXd zy;
};

/// The same as the paper does it, by the LCP of the grasp forces: with pi = I - H^+ H,
///     0 <= f = pi z + H^+ tau  _|_  z >= 0.
/// Limits that are not infinite are rows of it, too: f = pi (z - y) + H^+ tau, 0 <= limit - f  _|_  y >= 0.
/// Cost      an LCP of one row a muscle, and one a limit.
[[nodiscard]] MuscleReport solve_muscle_forces_by_lemke(const MuscleProblem& problem, MuscleWorkspace& work,
                                                        Eigen::Ref<Eigen::VectorXd> f) noexcept;

/// How far forces f with a multiplier l are from the optimum, as a share of the largest force: the largest of
/// |f_j - clamp((H' l)_j, 0, limit_j)| and of the forces that each joint's error of torque would be on its longest
/// arm, |H_i f - tau_i| / max_j |H_ij|. Zero at the optimum, and there only.
[[nodiscard]] double muscle_kkt_error(const MuscleProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& l,
                                      const Eigen::Ref<const Eigen::VectorXd>& f) noexcept;

/// How far joint velocities l are from a proof that no forces give the torques: the work that pulling muscles can do,
/// over that of the torques, sum limit_j max(0, (H' l)_j) / tau.l. A muscle without a limit may not pull along l at
/// all; rounding in H' l is taken for nothing. Below 1 it is a proof; infinity if tau.l <= 0.
[[nodiscard]] double muscle_infeasibility_gap(const MuscleProblem& problem,
                                              const Eigen::Ref<const Eigen::VectorXd>& l) noexcept;

/// The muscle that lacks most.
struct MuscleLack {
  int muscle = -1;  ///< -1: no muscle pulls along the proof's velocities, however strong.
  /// What it would have to pull at least while all others pull with their limits; infinite if there is no muscle.
  double needed_N = std::numeric_limits<double>::infinity();
};

/// Says from a proof that no forces give the torques, joint velocities l, which muscle is too weak: the one with the
/// largest part limit_j (H' l)_j of the work.
[[nodiscard]] MuscleLack muscle_lack(const MuscleProblem& problem, const Eigen::Ref<const Eigen::VectorXd>& l) noexcept;

}  // namespace thenar
