// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "engine/hand/hand.h"
#include "solvers/muscles/muscle_forces.h"

namespace thenar {

// Tendons have lengths l(q), and H = -dl/dq is their derivative: forces that do not change do no work on a closed path.
// A crossing is modelled in one of two ways.
// - Together: it names all joints between its two segments, or those of its finger if it connects two fingers. Then its
//   length is |M - V| for a point V that it pulls to, and -M.D for a direction D, as of a distant pulley, M and D at
//   the pose of the joints in between.
// - Each joint alone: all other joints are at zero. A direction fixed beyond its joints then keeps its moment arms at
//   zero, as a tendon in a sheath on the bone.

/// Computes the change of tendon length by the joints: l - l_0 of each muscle, l_0 a constant of the hand [m].
[[nodiscard]] Eigen::VectorXd muscle_lengths(const Hand& hand, const HandPose& pose);

/// Computes H = -dl/dq of tau = H f_m [1, 2]: H_ij = sum over crossings of share (O_i M_j x D_j) . T_i. Shape joints x
/// muscles [m].
void moment_arms(const Hand& hand, const HandPose& pose, Eigen::Ref<Eigen::MatrixXd> H);

/// One number per muscle, without heap memory.
using MuscleVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxMuscles, 1>;

/// A matrix over the joints of a finger, without heap memory.
using JointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxFingerJoints, kMaxFingerJoints>;

/// A muscle on one finger. A muscle shared by several fingers has a belly for each, with a share s of its force f and
/// of its stiffness k, so that with arms s a = h the finger gets s k a a' = (k / s) h h'.
struct Belly {
  int muscle = 0, finger = 0;
  double share = 1.0;    ///< Share of the muscle; 1 if it is on one finger.
  FingerVector arms_m;   ///< h: the finger's part of the muscle's column of H.
  JointMatrix slopes_m;  ///< dh/dq, symmetric.
};

/// Returns the bellies of a hand: which muscles pull which fingers. Their arms are zero until find_bellies().
[[nodiscard]] std::vector<Belly> bellies_of(const Hand& hand);

/// Computes the arms and slopes of bellies at a pose. Does not allocate.
void find_bellies(const Hand& hand, const HandPose& pose, std::span<Belly> bellies);

/// gamma of k = gamma f / L, the stiffness of muscle fibres of length L under a force f within the reach of their
/// cross-bridges: Cui et al. 2008 (J Biomech 41:1945).
inline constexpr double kShortRange = 23.4;

/// Strain of the fibres up to which that stiffness holds; beyond it cross-bridges let go, and the force no longer
/// changes with length. The literature has 0.0057 (De Groote et al. 2017, J Biomech 55:71, for a ten times larger
/// gamma) up to 0.038, where a spring and a damper still describe 90 % of the force (Kirsch et al. 1994, IEEE Trans
/// Biomed Eng 41:758). With gamma and 0.02 fibres yield at 1.47 f, near the 1.4 times their isometric force at which
/// lengthening muscles level off in Thelen 2003 (J Biomech Eng 125:70).
inline constexpr double kShortRangeStrain = 0.02;

/// Returns k = (L / (gamma f) + 1 / k_t)^-1, of fibres in series with their tendon [N/m]; 0 without force. Needs the
/// fibres' length. With a share s, k / s.
[[nodiscard]] inline double muscle_stiffness(const Muscle& muscle, double gamma, double force_N, double share = 1.0) {
  return force_N / (share * (1.0 / gamma * *muscle.fibre_m + force_N / muscle.tendon_N_per_m));
}

/// Returns k / s of a belly whose muscle pulls with f: with h of the belly, its finger gets (k / s) h h' [N/m].
[[nodiscard]] inline double belly_stiffness(const Hand& hand, const Belly& belly, double gamma, double force_N) {
  return muscle_stiffness(hand.muscles[belly.muscle], gamma, force_N, belly.share);
}

/// Effect of a belly's stretch in a tick. With arms h and the force f of its muscle, it drives its finger by h (f + x),
/// and pulls with s (f + x) itself.
struct BellyStretch {
  double more_N = 0.0;             ///< x, at the start of the tick.
  double stiffness_N_per_m = 0.0;  ///< k / s, by which x changes with -h' dq; 0: its fibres yield.
};

/// Returns the force x of a belly whose fibres have yielded to a stretch that by their stiffness would make it
/// `elastic_N`: at most gamma r f, lengthened, and at least -gamma r f, shortened, but never below -f, as a muscle does
/// not push. Nothing: the fibres are within their range r.
[[nodiscard]] inline std::optional<double> yielded_N(double gamma, double range, double force_N, double elastic_N) {
  const double most_N = gamma * range * force_N;
  if (!(std::abs(elastic_N) > most_N)) return std::nullopt;
  return elastic_N > 0.0 ? most_N : -std::min(most_N, force_N);
}

/// Computes H f.
[[nodiscard]] JointVector muscle_torques(const Hand& hand, std::span<const Belly> bellies,
                                         const Eigen::Ref<const Eigen::VectorXd>& forces_N);

/// Computes K of a finger: sum of k h h' - f dh/dq over its bellies, symmetric [N m/rad].
[[nodiscard]] JointMatrix muscle_stiffness(const Hand& hand, std::span<const Belly> bellies, int finger, double gamma,
                                           const Eigen::Ref<const Eigen::VectorXd>& forces_N);

/// Computes dg/dq of finger k, g of gravity_torques(): symmetric [N m/rad].
[[nodiscard]] JointMatrix gravity_stiffness(const Hand& hand, const HandPose& pose, int finger,
                                            const Eigen::Vector3d& gravity);

/// Computes d(J'f)/dq of a finger for a force with constant world components, J the Jacobian of a point of one of its
/// segments, now at `point_m`: symmetric [N m/rad].
[[nodiscard]] JointMatrix force_stiffness(const Hand& hand, const HandPose& pose, const Segment& segment,
                                          const Eigen::Vector3d& point_m, const Eigen::Vector3d& force_N);

}  // namespace thenar
