// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collision/implicit_surface.h"
#include "engine/hand/hand.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// A sphere of the hand that must stay out of the object, at `clearance_m` at least.
struct BodyPoint {
  int segment = -1;  ///< -1: the palm.
  int finger = 0, joints = 0;
  Eigen::Vector3d p_S = Eigen::Vector3d::Zero();  ///< Segment frame; hand frame for the palm.
  double clearance_m = 0.0;

  [[nodiscard]] Eigen::Vector3d in(const HandPose& pose) const {
    return segment < 0 ? p_S : Eigen::Vector3d(pose.segments[segment] * p_S);
  }
};

/// Returns the hand as spheres along its bones. A hand file has no skin: fingers have seven tenths of their pulps'
/// thickness, as flesh is soft, and the palm consists of bars from the wrist to the first joint of each finger and from
/// finger to finger.
[[nodiscard]] std::vector<BodyPoint> hand_body(const Hand& hand);

/// Spheres of two fingers with the least distance of their centres.
struct BonePair {
  int a = 0, b = 0;
  double least_m = 0.0;
};

/// The collision model between fingers, except between two pulps: spheres along bones up to the middles of pulps, as
/// thick as bones without flesh, half as thick as pulps, and the pairs that may not overlap. No required distance
/// exceeds that in the open hand, with each joint at zero, or at the end of its range nearest to zero.
struct Bones {
  std::vector<BodyPoint> points;
  std::vector<BonePair> pairs;
};
[[nodiscard]] Bones bones_of(const Hand& hand, const std::vector<BodyPoint>& body);

/// The pair of bones with the deepest overlap.
struct BoneOverlap {
  double depth_m = 0.0;
  int finger = -1, other = -1;  ///< -1: none overlap.
};
[[nodiscard]] BoneOverlap overlap_of(const Bones& bones, const HandPose& pose);

/// The position and normal of a finger's pulp, and their derivatives by the joints.
struct PulpPose {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< The pulp's mean outward direction, world.
  FingerJacobian J_centre, J_normal;
};
[[nodiscard]] PulpPose pulp_pose(const Hand& hand, const HandPose& pose, int finger);

/// Returns the distance of the centres of two pulps that touch on the line d (unit, world) between them.
[[nodiscard]] double touching_m(const Hand& hand, const HandPose& pose, int one, int other, const Eigen::Vector3d& d);

/// Returns the dexterity of a finger at its point x: the least over the largest singular value of its Jacobian there.
/// Near 0, stretched or folded, no torque pushes x in some direction, and the slightest push there rotates joints far.
[[nodiscard]] double dexterity(const Hand& hand, const HandPose& pose, int finger, const Eigen::Vector3d& x_m);

/// Returns the hand with only these of its fingers, in the order of the hand: joints, bones, fingertips, and their
/// muscles' parts. `fingers` are indices, in any order, each once.
[[nodiscard]] Hand hand_of(const Hand& hand, std::vector<int> fingers);

}  // namespace thenar
