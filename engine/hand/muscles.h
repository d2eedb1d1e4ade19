#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "engine/hand/hand.h"
#include "solvers/muscles/muscle_forces.h"

namespace thenar {

// Tendons have lengths l(q), and H = -dl/dq is their derivative: forces that do not change do no work on a closed path.
// A crossing is taken in one of two ways.
// - Together: it names all joints between its two segments, or those of its finger of a string between two fingers.
//   Then its length is |M - V| for a point V that it pulls to, and -M.D for a direction D, as of a pulley far away, M
//   and D as the joints in between have them.
// - Each joint alone: all other joints are as at zero. A direction that is fixed beyond its joints so keeps the moment
//   arms that it has at zero, as a tendon in a sheath on the bone.

/// How much of the lengths of tendons the joints take in: l - l_0 of each muscle, l_0 a constant of the hand [m].
[[nodiscard]] Eigen::VectorXd muscle_lengths(const Hand& hand, const HandPose& pose);

/// H = -dl/dq of tau = H f_m [1, 2]: H_ij = sum over crossings of share (O_i M_j x D_j) . T_i. Shape joints x muscles
/// [m].
void moment_arms(const Hand& hand, const HandPose& pose, Eigen::Ref<Eigen::MatrixXd> H);

/// One number a muscle, without a heap.
using MuscleVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxMuscles, 1>;

/// A matrix over the joints of a finger, without a heap.
using JointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxFingerJoints, kMaxFingerJoints>;

/// A muscle on one finger. One that several fingers share has a belly for each: of a share s of its force f and of its
/// stiffness k, so that with arms s a = h the finger gets s k a a' = (k / s) h h'.
struct Belly {
  int muscle = 0, finger = 0;
  double share = 1.0;    ///< Of the muscle; 1 of all that are on one finger.
  FingerVector arms_m;   ///< h: the finger's part of the muscle's column of H.
  JointMatrix slopes_m;  ///< dh/dq, symmetric.
};

/// The bellies of a hand: which muscles pull which fingers. Their arms are zero until find_bellies().
[[nodiscard]] std::vector<Belly> bellies_of(const Hand& hand);

/// Their arms and slopes at a pose. Does not allocate.
void find_bellies(const Hand& hand, const HandPose& pose, std::span<Belly> bellies);

/// gamma of k = gamma f / L, the stiffness of muscle fibres of length L under a force f within the reach of their
/// cross-bridges: Cui et al. 2008 (J Biomech 41:1945).
inline constexpr double kShortRange = 23.4;

/// k = (L / (gamma f) + 1 / k_t)^-1: fibres in series with their tendon [N/m]; 0 without force. Needs the fibres'
/// length. With a share s, k / s.
[[nodiscard]] inline double muscle_stiffness(const Muscle& muscle, double gamma, double force_N, double share = 1.0) {
  return force_N / (share * (1.0 / gamma * *muscle.fibre_m + force_N / muscle.tendon_N_per_m));
}

/// k / s of a belly whose muscle pulls by f: with h of the belly, its finger gets (k / s) h h' [N/m].
[[nodiscard]] inline double belly_stiffness(const Hand& hand, const Belly& belly, double gamma, double force_N) {
  return muscle_stiffness(hand.muscles[belly.muscle], gamma, force_N, belly.share);
}

/// H f.
[[nodiscard]] JointVector muscle_torques(const Hand& hand, std::span<const Belly> bellies,
                                         const Eigen::Ref<const Eigen::VectorXd>& forces_N);

/// K of a finger: sum of k h h' - f dh/dq over its bellies, symmetric [N m/rad].
[[nodiscard]] JointMatrix muscle_stiffness(const Hand& hand, std::span<const Belly> bellies, int finger, double gamma,
                                           const Eigen::Ref<const Eigen::VectorXd>& forces_N);

/// dg/dq of finger k, g of gravity_torques(): symmetric [N m/rad].
[[nodiscard]] JointMatrix gravity_stiffness(const Hand& hand, const HandPose& pose, int finger,
                                            const Eigen::Vector3d& gravity);

/// d(J'f)/dq of a finger, J the Jacobian of a point of one of its segments that is now at `point_m`, for a force that
/// keeps its world components: symmetric [N m/rad].
[[nodiscard]] JointMatrix force_stiffness(const Hand& hand, const HandPose& pose, const Segment& segment,
                                          const Eigen::Vector3d& point_m, const Eigen::Vector3d& force_N);

}  // namespace thenar
