#pragma once

#include <Eigen/Core>
#include <vector>

#include "collision/implicit_surface.h"
#include "engine/hand/hand.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// A sphere of the hand, which is to stay out of the object: so far at least.
struct BodyPoint {
  int segment = -1;  ///< -1: the palm.
  int finger = 0, joints = 0;
  Eigen::Vector3d p_S = Eigen::Vector3d::Zero();  ///< Segment frame; of the palm hand frame.
  double clearance_m = 0.0;

  [[nodiscard]] Eigen::Vector3d in(const HandPose& pose) const {
    return segment < 0 ? p_S : Eigen::Vector3d(pose.segments[segment] * p_S);
  }
};

/// The hand as spheres along its bones. A hand file has no skin: fingers are taken to be as thick as seven tenths of
/// their pulps, for flesh gives way, and the palm as bars from the wrist to the first joint of each finger and from
/// finger to finger.
[[nodiscard]] std::vector<BodyPoint> hand_body(const Hand& hand);

/// Two fingers' spheres whose centres are to stay so far apart.
struct BonePair {
  int a = 0, b = 0;
  double least_m = 0.0;
};

/// What keeps fingers out of one another, but for two pulps: spheres along bones up to the middles of pulps, as thick
/// as bones without their flesh, half as thick as pulps, and which of them may not overlap. None needs to be further
/// from another than it is in the open hand, with each joint at
/// zero, or at the end of its range that is nearest to it.
struct Bones {
  std::vector<BodyPoint> points;
  std::vector<BonePair> pairs;
};
[[nodiscard]] Bones bones_of(const Hand& hand, const std::vector<BodyPoint>& body);

/// The pair of bones that are deepest in one another.
struct BoneOverlap {
  double depth_m = 0.0;
  int finger = -1, other = -1;  ///< None are: -1.
};
[[nodiscard]] BoneOverlap overlap_of(const Bones& bones, const HandPose& pose);

/// Where finger k's pulp is, how it turns, and how both move with the joints.
struct PulpPose {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< The pulp's mean outward direction, world.
  FingerJacobian J_centre, J_normal;
};
[[nodiscard]] PulpPose pulp_pose(const Hand& hand, const HandPose& pose, int finger);

/// How far the centres of two pulps are from each other where they touch on the line d (unit, world) between them.
[[nodiscard]] double touching_m(const Hand& hand, const HandPose& pose, int one, int other, const Eigen::Vector3d& d);

/// How far finger k is from being stretched or folded at its point x: the least over the largest singular value of its
/// Jacobian there. Near 0 no torque pushes x in some direction, and the slightest push there turns joints far.
[[nodiscard]] double dexterity(const Hand& hand, const HandPose& pose, int finger, const Eigen::Vector3d& x_m);

/// The hand with these of its fingers alone, in the order of the hand: joints, bones, fingertips, and what their
/// muscles do there. `fingers` are indices, in any order, each once.
[[nodiscard]] Hand hand_of(const Hand& hand, std::vector<int> fingers);

}  // namespace thenar
