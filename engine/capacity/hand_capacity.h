// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/capacity/force_limit.h"
#include "engine/grasp/model.h"
#include "engine/hand/hand.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// A hand in a posture, with the contacts of its fingers.
struct HandGrip {
  const Hand& hand;
  HandPose pose;
  std::vector<GraspContact> contacts;                  ///< One per finger.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< The point of the object that torques are taken about.
};

/// Returns the grip at a scene's start, with the controller's contacts.
[[nodiscard]] HandGrip grip_at_start(const Model& model);

/// A muscle at its largest force.
struct LimitingMuscle {
  int muscle = 0;
  double gain = 0.0;   ///< Gain of force per newton of it [N/N].
  double share = 0.0;  ///< Share of the force: gain times the muscle's largest force, over it. The sum is 1.
};

/// The largest force of a kind by the muscles, with tau = H f - J' f_c = 0 in all joints, 0 <= f <= max_force: at rest,
/// without gravity, with joints held by muscles alone.
struct LargestForce {
  LimitStatus status = LimitStatus::kUnproved;  ///< kUnbounded: bones alone carry it.
  double force_N = 0.0;
  Eigen::VectorXd muscles_N;
  Eigen::Matrix3Xd contacts_N;           ///< On the object, world axes: a column per finger.
  std::vector<LimitingMuscle> limiting;  ///< The muscles with a price, the largest gain first.
  double residual = 0.0;                 ///< See ForceLimit.
};

/// Computes the largest normal force of the first finger in a pinch of all fingers on an object in equilibrium, each
/// within its friction cone.
[[nodiscard]] LargestForce largest_pinch(const HandGrip& grip, double friction);

/// Computes the largest force of a finger in exactly this direction (world, unit).
[[nodiscard]] LargestForce largest_along(const HandGrip& grip, int finger, const Eigen::Vector3d& direction);

/// Computes the largest normal force of a finger, with any tangential force within its friction cone.
[[nodiscard]] LargestForce largest_normal(const HandGrip& grip, int finger, double friction);

/// A direction in which a finger presses.
struct PressDirection {
  double angle_rad = 0.0;  ///< In the flexion plane, from the pulp's own direction towards its tip.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  LargestForce largest;
};

struct FingerCapacity {
  LargestForce normal;                    ///< Along the contact's normal, without tangential force.
  LargestForce normal_with_friction;      ///< Along the normal, with friction.
  std::vector<PressDirection> ring;       ///< Forces in the plane of its last joint, every 30 degrees.
  LargestForce along_axis, against_axis;  ///< Perpendicular to that plane: along the last joint's axis.
};

struct HandCapacity {
  double friction = 0.0;
  LargestForce pinch;
  std::vector<FingerCapacity> fingers;
};

[[nodiscard]] HandCapacity hand_capacity(const HandGrip& grip, double friction);

}  // namespace thenar
