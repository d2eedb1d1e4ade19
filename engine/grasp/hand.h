#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

inline constexpr int kFingers = 3;  ///< Thumb, index, major.
inline constexpr int kJointsPerFinger = 4;
inline constexpr int kJoints = kFingers * kJointsPerFinger;

using JointVector = Eigen::Matrix<double, kJoints, 1>;
using FingerJacobian = Eigen::Matrix<double, 3, kJointsPerFinger>;

/// A revolute joint, as it stands at q = 0, in the hand frame.
struct Joint {
  std::string name;
  Eigen::Vector3d origin_m;
  Eigen::Vector3d axis;                     ///< Unit; positive angles flex or abduct.
  double lower_rad = 0.0, upper_rad = 0.0;  ///< Range of motion.
};

/// A rigid bone; the palm is the one that no joint moves.
struct Segment {
  std::string name;
  int finger = 0;            ///< Whose joints move it.
  int joints = 0;            ///< How many of them, from the first on.
  Eigen::Isometry3d X_WS_0;  ///< Its frame at q = 0: x along the bone, y palmar, z the flexion axis.
  double length_m = 0.0;
  double mass_kg = 0.0;
  Eigen::Vector3d com_m = Eigen::Vector3d::Zero();  ///< Centre of mass, segment frame.
};

/// The pulp of a finger: a sphere fixed in the distal segment.
struct Fingertip {
  std::string finger;
  int segment = 0;           ///< Index of the distal segment.
  Eigen::Vector3d centre_m;  ///< Segment frame.
  double radius_m = 0.0;
  Eigen::Vector3d normal;  ///< Mean outward direction of the pulp, unit, segment frame.
};

/// Where a tendon crosses joints: it pulls at an attachment distal to them, in the direction of a via point or of a
/// vector fixed in a segment.
struct MuscleCrossing {
  std::vector<int> joints;
  double share = 1.0;  ///< Of the muscle's force.
  int insertion_segment = 0;
  Eigen::Vector3d insertion_m;
  int pull_segment = 0;
  Eigen::Vector3d pull;  ///< A point [m] if pull_is_point, else a direction; segment frame.
  bool pull_is_point = false;
};

struct Muscle {
  std::string name;
  double max_force_N = 0.0;
  std::vector<MuscleCrossing> crossings;
};

/// The hand's geometry and masses: data only.
struct Hand {
  std::array<Joint, kJoints> joints;
  std::vector<Segment> segments;
  std::array<Fingertip, kFingers> fingertips;
  std::vector<Muscle> muscles;
};

/// Where the joints and segments are at some q, world = hand frame.
struct HandPose {
  std::array<Eigen::Vector3d, kJoints> origin_m;
  std::array<Eigen::Vector3d, kJoints> axis;
  std::vector<Eigen::Isometry3d> segments;  ///< X_WS, as many as the hand has.

  /// Frame of the segment that carries finger k's pulp.
  [[nodiscard]] const Eigen::Isometry3d& distal(const Hand& hand, int finger) const {
    return segments[hand.fingertips[finger].segment];
  }
};

/// Forward kinematics by products of exponentials: T_k = exp(q_1 A_1 about O_1) ... exp(q_k A_k about O_k).
/// `pose.segments` keeps its memory.
void forward_kinematics(const Hand& hand, const JointVector& q, HandPose& pose);

/// J_k: the velocity of a point of finger k's distal segment that is now at `point_m` (world) for its four joint
/// speeds.
[[nodiscard]] FingerJacobian finger_jacobian(const HandPose& pose, int finger, const Eigen::Vector3d& point_m);

/// g(q) of eq. (3): b qdot + g = tau - J' f, so g = -sum J_com' m gravity [N m].
[[nodiscard]] JointVector gravity_torques(const Hand& hand, const HandPose& pose, const Eigen::Vector3d& gravity);

/// H of tau = H f_m [1, 2]: H_ij = sum over crossings of share (O_i M_j x D_j) . T_i. Shape joints x muscles [m].
void moment_arms(const Hand& hand, const HandPose& pose, Eigen::Ref<Eigen::MatrixXd> H);

}  // namespace thenar
