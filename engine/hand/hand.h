// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "collision/pulp_shape.h"
#include "thenar/eigen_layout.h"

namespace thenar {

inline constexpr int kMaxFingers = 5, kMaxFingerJoints = 5;
inline constexpr int kMaxHandJoints = kMaxFingers * kMaxFingerJoints;

/// A container with one value per finger of a hand, without heap memory.
template <typename T>
class PerFinger {
 public:
  PerFinger() = default;
  explicit PerFinger(int fingers, const T& value = {}) : size_(fingers) {
    for (T& one : *this) one = value;
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] T& operator[](std::size_t k) { return values_[k]; }
  [[nodiscard]] const T& operator[](std::size_t k) const { return values_[k]; }
  [[nodiscard]] const T* data() const { return values_.data(); }
  [[nodiscard]] T* begin() { return values_.data(); }
  [[nodiscard]] T* end() { return begin() + size_; }
  [[nodiscard]] const T* begin() const { return values_.data(); }
  [[nodiscard]] const T* end() const { return begin() + size_; }

 private:
  std::array<T, kMaxFingers> values_{};
  std::size_t size_ = 0;
};

/// One number per joint, finger by finger. Room for whole registers aligns it: the order of sums depends on that.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, (kMaxHandJoints + 3) / 4 * 4, 1>;
/// One number per joint of a finger, padded with zeros to four, which fill a register.
using FingerVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxFingerJoints, 1>;
using FingerJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxFingerJoints>;  ///< Likewise, columns.

/// A revolute joint at q = 0, in the hand frame. In a hand with Hand::slides it is prismatic along its axis.
struct Joint {
  std::string name;
  Eigen::Vector3d origin_m;
  Eigen::Vector3d axis;                     ///< Unit; positive angles flex or abduct.
  double lower_rad = 0.0, upper_rad = 0.0;  ///< Range of motion; in m if prismatic.
  double drag = 1.0;                        ///< Its viscosity over its finger's; above 1 if others follow it.
};

/// A joint coupled to one of its finger that is nearer to the palm: see engine/hand/coupled_joints.h. It is not in q.
struct Follower {
  Joint joint;
  int leader = 0;  ///< Index of the joint that it follows.
  double ratio = 1.0, offset_rad = 0.0;
  int after = 0;  ///< Number of its finger's joints that are nearer to the palm.

  template <typename Angles>
  [[nodiscard]] double angle(const Angles& q) const {
    return ratio * q[leader] + offset_rad;
  }
};

/// A rigid bone; the palm is the one that no joint moves.
struct Segment {
  std::string name;
  int finger = 0;            ///< Finger whose joints move it.
  int joints = 0;            ///< Number of these joints, from the first on.
  int followers = 0;         ///< Number of followers that move it, likewise.
  Eigen::Isometry3d X_WS_0;  ///< Its frame at q = 0: x along the bone, y palmar, z the flexion axis.
  double length_m = 0.0;
  double mass_kg = 0.0;
  Eigen::Vector3d com_m = Eigen::Vector3d::Zero();  ///< Centre of mass, segment frame.
};

/// A finger: a chain of joints, and at its end the pulp, fixed in the distal segment.
struct Fingertip {
  std::string finger;
  int first_joint = 0, joints = 0;        ///< Its joints among the hand's: first and number, one to five.
  int first_follower = 0, followers = 0;  ///< Its followers, likewise.
  int segment = 0;                        ///< Index of the distal segment.
  Eigen::Vector3d centre_m;               ///< Centre of the pulp, segment frame.
  double radius_m = 0.0;                  ///< Radius of the pulp, or of the largest sphere about the centre inside it.
  std::optional<PulpShape> shape = {};    ///< Shape of the pulp; nothing: a sphere.
  Eigen::Vector3d normal;                 ///< Mean outward direction of the pulp, unit, segment frame.
  // Values of this finger; nothing: those of the scene for all fingers.
  std::optional<double> joint_viscosity;                            ///< Viscosity b of its joints [N m s].
  std::optional<double> reduced_modulus_Pa, poisson, relaxation_s;  ///< Material of its pulp: see PulpMaterial.

  [[nodiscard]] bool has_joint(int joint) const { return joint >= first_joint && joint < first_joint + joints; }
};

/// The crossing of joints by a tendon: it pulls at an attachment distal to them, towards a via point or along a vector
/// fixed in a segment. engine/hand/muscles.h has the law of lengths.
struct MuscleCrossing {
  std::vector<int> joints;  ///< Joints crossed, from the palm on; followers are numbered after the joints.
  double share = 1.0;       ///< Fraction of the muscle's force.
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
  std::optional<double> fibre_m = {};                               ///< Rest length of its fibres.
  double tendon_N_per_m = std::numeric_limits<double>::infinity();  ///< Stiffness of its tendon; infinite: rigid.
};

/// The hand's geometry and masses: data only.
struct Hand {
  std::vector<Joint> joints;        ///< Independent joints, finger by finger, each from the palm on.
  std::vector<Follower> followers;  ///< Coupled joints, likewise.
  std::vector<Segment> segments;
  std::vector<Fingertip> fingertips;  ///< One per finger.
  std::vector<Muscle> muscles;
  bool mirrored = false;  ///< True for the mirror image of its file's hand: see mirrored().
  /// Joints are prismatic: they translate their fingertips along their axes; q is in m, drives in N, viscosity in N
  /// s/m. There are no couplings and no muscles then.
  bool slides = false;

  [[nodiscard]] int fingers() const { return static_cast<int>(fingertips.size()); }
  /// Returns joint i; followers are numbered after the joints.
  [[nodiscard]] const Joint& joint(int i) const {
    return i < std::ssize(joints) ? joints[i] : followers[i - joints.size()].joint;
  }
  /// Returns the joint whose angle moves joint i: itself, or its leader.
  [[nodiscard]] int leader(int i) const { return i < std::ssize(joints) ? i : followers[i - joints.size()].leader; }
  /// Returns the ratio of joint i's rate to its leader's.
  [[nodiscard]] double ratio(int i) const { return i < std::ssize(joints) ? 1.0 : followers[i - joints.size()].ratio; }
  /// Tests whether joint i moves a segment.
  [[nodiscard]] bool moves(int i, const Segment& segment) const {
    const Fingertip& tip = fingertips[segment.finger];
    const std::ptrdiff_t first = i < std::ssize(joints) ? tip.first_joint : std::ssize(joints) + tip.first_follower;
    return i >= first && i < first + (i < std::ssize(joints) ? segment.joints : segment.followers);
  }
  /// Returns zero for each joint.
  [[nodiscard]] JointVector at_zero() const { return JointVector::Zero(static_cast<Eigen::Index>(joints.size())); }
  /// Returns finger k's part of a vector of all joints.
  [[nodiscard]] FingerVector of_finger(int k, const JointVector& all) const {
    FingerVector own = FingerVector::Zero(std::max(4, fingertips[k].joints));
    own.head(fingertips[k].joints) = all.segment(fingertips[k].first_joint, fingertips[k].joints);
    return own;
  }
};

/// Returns the mirror image of a hand in the plane z = 0 of the hand frame, with right-handed segment frames. The same
/// joint angles give mirror images of poses; moment arms are the same.
[[nodiscard]] Hand mirrored(Hand hand);

/// The poses of joints and segments at some q, world = hand frame.
struct HandPose {
  JointVector q;                                         ///< [rad]
  std::array<Eigen::Vector3d, kMaxHandJoints> origin_m;  ///< Origins of the joints, then of the followers.
  std::array<Eigen::Vector3d, kMaxHandJoints> axis;
  std::vector<Eigen::Isometry3d> segments;  ///< X_WS of each segment.

  /// Returns the frame of the segment that carries the finger's pulp.
  [[nodiscard]] const Eigen::Isometry3d& distal(const Hand& hand, int finger) const {
    return segments[hand.fingertips[finger].segment];
  }
};

/// Computes forward kinematics by products of exponentials: T_k = exp(q_1 A_1 about O_1) ... exp(q_k A_k about O_k); of
/// prismatic joints the translation by q_1 a_1 + ... + q_k a_k. `pose.segments` keeps its memory.
void forward_kinematics(const Hand& hand, const JointVector& q, HandPose& pose);

/// Returns the velocity of a point now at `point_m` (world) of a moved body for unit speed of a revolute joint: a x d.
/// Fused products are explicit, so that rounding is the same wherever it is inlined.
[[nodiscard]] inline Eigen::Vector3d joint_column(const HandPose& pose, int joint, const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d& a = pose.axis[joint];
  const Eigen::Vector3d d = point_m - pose.origin_m[joint];
  return {std::fma(a[1], d[2], -(a[2] * d[1])), std::fma(a[2], d[0], -(a[0] * d[2])),
          std::fma(a[0], d[1], -(a[1] * d[0]))};
}

/// Computes J_k: the velocity of a point of finger k's distal segment, now at `point_m` (world), by its joints' speeds.
[[nodiscard]] FingerJacobian finger_jacobian(const Hand& hand, const HandPose& pose, int finger,
                                             const Eigen::Vector3d& point_m);

/// Computes the Jacobian of a point of any segment; only the columns of joints that move it are valid.
[[nodiscard]] FingerJacobian segment_jacobian(const Hand& hand, const HandPose& pose, const Segment& segment,
                                              const Eigen::Vector3d& point_m);

/// Computes the angular velocity of finger k's distal segment by its joints' speeds; zero for prismatic joints.
[[nodiscard]] FingerJacobian turning_axes(const Hand& hand, const HandPose& pose, int finger);

/// Compute a.b, J q' and J J', four joints in a register.
[[nodiscard]] double dot(const FingerVector& a, const FingerVector& b);
[[nodiscard]] Eigen::Vector3d velocity(const FingerJacobian& J, const FingerVector& speeds);
[[nodiscard]] Eigen::Matrix3d squared(const FingerJacobian& J);

/// Computes g(q) of eq. (3): b qdot + g = tau - J' f, so g = -sum J_com' m gravity [N m; N if prismatic].
[[nodiscard]] JointVector gravity_torques(const Hand& hand, const HandPose& pose, const Eigen::Vector3d& gravity);

}  // namespace thenar
