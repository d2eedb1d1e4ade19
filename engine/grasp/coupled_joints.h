#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <string>

#include "engine/grasp/hand.h"

namespace thenar {

/// One joint of a hand turns with another one of its finger: q_joint = ratio q_leader + offset. The angles that are left
/// are those of joints that turn by themselves: all angles are S q + q0, and all that acts on the joints, such as
/// J' f, g and H f_m, acts on these by S'. Each of the chain's joints gives way as its finger's joints do, so that
/// S' b S = b (1 + sum of ratio^2) is a leader's viscosity: Joint::drag.
struct Coupling {
  int joint = 0, leader = 0;
  double ratio = 1.0, offset_rad = 0.0;
};

/// What is wrong with the last of these couplings of a hand whose joints all turn by themselves, in words; empty if it
/// fits to those before it.
[[nodiscard]] std::string coupling_fault(const Hand& hand, std::span<const Coupling> couplings);

/// The hand in which these joints follow others. A leader keeps to the limits of its followers, too.
[[nodiscard]] Hand coupled(Hand hand, std::span<const Coupling> couplings);

/// What the finger's first joints displace, from none to all of them.
using FingerChain = std::array<Eigen::Isometry3d, kMaxFingerJoints + 1>;

// Of a finger in which joints follow others, these are what hand.h names likewise.
void coupled_kinematics(const Hand& hand, const JointVector& q, int finger, FingerChain& chain, HandPose& pose);

/// Of a point that the first `followers` of the finger's followers move, and the joints before them.
[[nodiscard]] FingerJacobian coupled_jacobian(const Hand& hand, const HandPose& pose, int finger, int followers,
                                              const Eigen::Vector3d& point_m);

/// Adds to a muscle's column of H what a crossing gives of the followers. M is its attachment and D its direction.
void add_coupled_arms(const Hand& hand, const HandPose& pose, const MuscleCrossing& crossing, const Eigen::Vector3d& M,
                      const Eigen::Vector3d& D, Eigen::Ref<Eigen::VectorXd> H_m);

/// The axes about which the finger's joints turn its last segment: its angular velocity for their speeds.
[[nodiscard]] FingerJacobian coupled_axes(const Hand& hand, const HandPose& pose, int finger);

}  // namespace thenar
