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

/// What there is one of for each finger of a hand, without a heap.
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

/// One number a joint, finger by finger. Room for whole registers aligns it: the order of sums depends on that.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, (kMaxHandJoints + 3) / 4 * 4, 1>;
/// One number a joint of a finger, and zeros for what it has less than four: four fill a register.
using FingerVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxFingerJoints, 1>;
using FingerJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxFingerJoints>;  ///< Likewise, columns.

/// A revolute joint, as it stands at q = 0, in the hand frame. In a hand that slides (Hand::slides) it is a slide along
/// its axis.
struct Joint {
  std::string name;
  Eigen::Vector3d origin_m;
  Eigen::Vector3d axis;                     ///< Unit; positive angles flex or abduct.
  double lower_rad = 0.0, upper_rad = 0.0;  ///< Range of motion; of a slide in m.
  double drag = 1.0;                        ///< Its viscosity over its finger's: more than 1 where others follow it.
};

/// A joint that turns with another one of its finger, nearer to the palm: see engine/hand/coupled_joints.h. It has no
/// angle of its own in q.
struct Follower {
  Joint joint;
  int leader = 0;  ///< Index of the joint that it follows.
  double ratio = 1.0, offset_rad = 0.0;
  int after = 0;  ///< So many of its finger's joints are nearer to the palm.

  template <typename Angles>
  [[nodiscard]] double angle(const Angles& q) const {
    return ratio * q[leader] + offset_rad;
  }
};

/// A rigid bone; the palm is the one that no joint moves.
struct Segment {
  std::string name;
  int finger = 0;            ///< Whose joints move it.
  int joints = 0;            ///< How many of them, from the first on.
  int followers = 0;         ///< Likewise.
  Eigen::Isometry3d X_WS_0;  ///< Its frame at q = 0: x along the bone, y palmar, z the flexion axis.
  double length_m = 0.0;
  double mass_kg = 0.0;
  Eigen::Vector3d com_m = Eigen::Vector3d::Zero();  ///< Centre of mass, segment frame.
};

/// A finger: a chain of joints, and at its end the pulp, fixed in the distal segment.
struct Fingertip {
  std::string finger;
  int first_joint = 0, joints = 0;        ///< So many of the hand's joints, from this one on: one to five.
  int first_follower = 0, followers = 0;  ///< Likewise of those that follow them.
  int segment = 0;                        ///< Index of the distal segment.
  Eigen::Vector3d centre_m;               ///< Segment frame.
  double radius_m = 0.0;  ///< Of the sphere that the pulp is, or of the largest about the centre that is in it.
  std::optional<PulpShape> shape = {};  ///< Nothing: a sphere.
  Eigen::Vector3d normal;               ///< Mean outward direction of the pulp, unit, segment frame.
  // What the hand says of this finger; nothing: the scene says it of all.
  std::optional<double> joint_viscosity;                            ///< b of its joints [N m s].
  std::optional<double> reduced_modulus_Pa, poisson, relaxation_s;  ///< Of its pulp: see PulpMaterial.

  [[nodiscard]] bool has_joint(int joint) const { return joint >= first_joint && joint < first_joint + joints; }
};

/// Where a tendon crosses joints: it pulls at an attachment distal to them, in the direction of a via point or of a
/// vector fixed in a segment. How that makes a length is in engine/hand/muscles.h.
struct MuscleCrossing {
  std::vector<int> joints;  ///< From the palm on; followers count on from the joints.
  double share = 1.0;       ///< Of the muscle's force.
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
  std::optional<double> fibre_m = {};                               ///< Length of its fibres at rest.
  double tendon_N_per_m = std::numeric_limits<double>::infinity();  ///< Stiffness of its tendon; infinite: rigid.
};

/// The hand's geometry and masses: data only.
struct Hand {
  std::vector<Joint> joints;        ///< Finger by finger, each from the palm on: those that turn by themselves.
  std::vector<Follower> followers;  ///< Likewise: those that turn with others.
  std::vector<Segment> segments;
  std::vector<Fingertip> fingertips;  ///< One a finger.
  std::vector<Muscle> muscles;
  bool mirrored = false;  ///< It is the other hand than its file's: see mirrored().
  /// Its joints are slides, which move their fingertips along their axes without a turn: q is in m, what drives them
  /// in N, viscosity in N s/m. No joint follows another one then, and there are no muscles.
  bool slides = false;

  [[nodiscard]] int fingers() const { return static_cast<int>(fingertips.size()); }
  /// Joint i, where followers count on from the joints.
  [[nodiscard]] const Joint& joint(int i) const {
    return i < std::ssize(joints) ? joints[i] : followers[i - joints.size()].joint;
  }
  /// Whose angle turns it: itself, or its leader.
  [[nodiscard]] int leader(int i) const { return i < std::ssize(joints) ? i : followers[i - joints.size()].leader; }
  /// How fast it turns with that one.
  [[nodiscard]] double ratio(int i) const { return i < std::ssize(joints) ? 1.0 : followers[i - joints.size()].ratio; }
  /// Whether it moves a segment.
  [[nodiscard]] bool moves(int i, const Segment& segment) const {
    const Fingertip& tip = fingertips[segment.finger];
    const std::ptrdiff_t first = i < std::ssize(joints) ? tip.first_joint : std::ssize(joints) + tip.first_follower;
    return i >= first && i < first + (i < std::ssize(joints) ? segment.joints : segment.followers);
  }
  /// Zero for each joint.
  [[nodiscard]] JointVector at_zero() const { return JointVector::Zero(static_cast<Eigen::Index>(joints.size())); }
  /// What finger k has of a vector of all joints.
  [[nodiscard]] FingerVector of_finger(int k, const JointVector& all) const {
    FingerVector own = FingerVector::Zero(std::max(4, fingertips[k].joints));
    own.head(fingertips[k].joints) = all.segment(fingertips[k].first_joint, fingertips[k].joints);
    return own;
  }
};

/// The other hand: the mirror image in the plane z = 0 of the hand frame, with right-handed segment frames. The same
/// joint angles make mirror images of poses, and moment arms are the same.
[[nodiscard]] Hand mirrored(Hand hand);

/// Where the joints and segments are at some q, world = hand frame.
struct HandPose {
  JointVector q;                                         ///< [rad]
  std::array<Eigen::Vector3d, kMaxHandJoints> origin_m;  ///< Of each joint the hand has, and then of each follower.
  std::array<Eigen::Vector3d, kMaxHandJoints> axis;
  std::vector<Eigen::Isometry3d> segments;  ///< X_WS, as many as the hand has.

  /// Frame of the segment that carries finger k's pulp.
  [[nodiscard]] const Eigen::Isometry3d& distal(const Hand& hand, int finger) const {
    return segments[hand.fingertips[finger].segment];
  }
};

/// Forward kinematics by products of exponentials: T_k = exp(q_1 A_1 about O_1) ... exp(q_k A_k about O_k); of slides
/// the translation by q_1 a_1 + ... + q_k a_k. `pose.segments` keeps its memory.
void forward_kinematics(const Hand& hand, const JointVector& q, HandPose& pose);

/// The velocity that a joint's unit speed gives a point now at `point_m` (world) of what it turns: a x d. Which
/// products are rounded is written out, so that it is the same wherever it is inlined.
[[nodiscard]] inline Eigen::Vector3d joint_column(const HandPose& pose, int joint, const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d& a = pose.axis[joint];
  const Eigen::Vector3d d = point_m - pose.origin_m[joint];
  return {std::fma(a[1], d[2], -(a[2] * d[1])), std::fma(a[2], d[0], -(a[0] * d[2])),
          std::fma(a[0], d[1], -(a[1] * d[0]))};
}

/// J_k: the velocity of a point of finger k's distal segment that is now at `point_m` (world) for its joints' speeds.
[[nodiscard]] FingerJacobian finger_jacobian(const Hand& hand, const HandPose& pose, int finger,
                                             const Eigen::Vector3d& point_m);

/// Likewise of a point of any segment; only the columns of the joints that move it count.
[[nodiscard]] FingerJacobian segment_jacobian(const Hand& hand, const HandPose& pose, const Segment& segment,
                                              const Eigen::Vector3d& point_m);

/// The angular velocity of finger k's distal segment for its joints' speeds; zero of slides.
[[nodiscard]] FingerJacobian turning_axes(const Hand& hand, const HandPose& pose, int finger);

/// a.b, J q' and J J', four joints in a register.
[[nodiscard]] double dot(const FingerVector& a, const FingerVector& b);
[[nodiscard]] Eigen::Vector3d velocity(const FingerJacobian& J, const FingerVector& speeds);
[[nodiscard]] Eigen::Matrix3d squared(const FingerJacobian& J);

/// g(q) of eq. (3): b qdot + g = tau - J' f, so g = -sum J_com' m gravity [N m; N of slides].
[[nodiscard]] JointVector gravity_torques(const Hand& hand, const HandPose& pose, const Eigen::Vector3d& gravity);

}  // namespace thenar
