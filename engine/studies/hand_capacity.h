#pragma once

#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/hand/hand.h"
#include "engine/studies/force_limit.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// A hand in a posture, and where its fingers act.
struct HandGrip {
  const Hand& hand;
  HandPose pose;
  std::vector<GraspContact> contacts;                  ///< One a finger.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< The point of the object that torques are taken about.
};

/// That of a scene's start: fingers act where the controller takes them to act.
[[nodiscard]] HandGrip grip_at_start(const Model& model);

/// A muscle at its largest force.
struct LimitingMuscle {
  int muscle = 0;
  double gain = 0.0;   ///< What 1 N more of it gives [N/N].
  double share = 0.0;  ///< Of the force: gain times the muscle's largest force, over it. All together make 1.
};

/// The largest force of a kind that muscles can give, with tau = H f - J' f_c = 0 in all joints, 0 <= f <= max_force:
/// at rest, without gravity, and joints that their muscles alone hold.
struct LargestForce {
  LimitStatus status = LimitStatus::kUnproved;  ///< Unbounded: bones alone carry it.
  double force_N = 0.0;
  Eigen::VectorXd muscles_N;
  Eigen::Matrix3Xd contacts_N;           ///< On the object, world axes: a column a finger.
  std::vector<LimitingMuscle> limiting;  ///< The muscles with a price, that of the largest gain first.
  double residual = 0.0;                 ///< See ForceLimit.
};

/// The largest normal force of the first finger in which all fingers squeeze an object that stays in balance, each
/// within its friction cone.
[[nodiscard]] LargestForce largest_pinch(const HandGrip& grip, double friction);

/// The largest force of a finger in this direction (world, unit), exactly: nothing across it.
[[nodiscard]] LargestForce largest_along(const HandGrip& grip, int finger, const Eigen::Vector3d& direction);

/// The largest normal force of a finger, with any tangential force within its friction cone.
[[nodiscard]] LargestForce largest_normal(const HandGrip& grip, int finger, double friction);

/// A direction in which a finger presses.
struct PressDirection {
  double angle_rad = 0.0;  ///< In the flexion plane, from the pulp's own direction towards its tip.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  LargestForce largest;
};

struct FingerCapacity {
  LargestForce normal;                    ///< Along the contact's normal, nothing across,
  LargestForce normal_with_friction;      ///< and with friction.
  std::vector<PressDirection> ring;       ///< In the plane of its last joint, every 30 degrees.
  LargestForce along_axis, against_axis;  ///< Across that plane: along the last joint's axis.
};

struct HandCapacity {
  double friction = 0.0;
  LargestForce pinch;
  std::vector<FingerCapacity> fingers;
};

[[nodiscard]] HandCapacity hand_capacity(const HandGrip& grip, double friction);

}  // namespace thenar
