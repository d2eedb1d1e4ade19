// SPDX-License-Identifier: Apache-2.0
#include "engine/hand/hand.h"

namespace thenar {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

namespace {

/// The displacements by the first joints of a finger, from none to all of them.
using FingerChain = std::array<Isometry3d, kMaxFingerJoints + 1>;

// For fingers with prismatic or coupled joints. Separate functions: inlined, they would change the contraction of
// products for all other fingers, and the last bits of results.

[[gnu::noinline]] void slide_kinematics(const Hand& hand, const JointVector& q, const Fingertip& tip,
                                        FingerChain& chain, HandPose& pose) {
  chain[0].setIdentity();
  for (int j = 0; j < tip.joints; ++j) {
    const int i = tip.first_joint + j;
    const Joint& joint = hand.joints[i];
    pose.origin_m[i] = chain[j] * joint.origin_m;
    pose.axis[i] = joint.axis;
    chain[j + 1] = chain[j];
    chain[j + 1].translation() += q[i] * joint.axis;
  }
}

[[gnu::noinline]] FingerJacobian slide_jacobian(const HandPose& pose, const Fingertip& tip) {
  FingerJacobian J = FingerJacobian::Zero(3, std::max(4, tip.joints));
  for (int j = 0; j < tip.joints; ++j) J.col(j) = pose.axis[tip.first_joint + j];
  return J;
}

[[gnu::noinline]] void coupled_kinematics(const Hand& hand, const JointVector& q, const Fingertip& tip,
                                          FingerChain& chain, HandPose& pose) {
  int at = 0, next = tip.first_follower;
  const auto turn = [&](const Joint& joint, std::size_t place, double angle) {
    pose.origin_m[place] = chain[at] * joint.origin_m;
    pose.axis[place] = chain[at].linear() * joint.axis;
    const Translation3d to_joint(joint.origin_m);
    chain[at + 1] = chain[at] * to_joint * AngleAxisd(angle, joint.axis) * to_joint.inverse();
    ++at;
  };
  chain[0].setIdentity();
  for (int j = 0; j < tip.joints; ++j) {
    turn(hand.joints[tip.first_joint + j], tip.first_joint + j, q[tip.first_joint + j]);
    for (; next < tip.first_follower + tip.followers && hand.followers[next].after == j + 1; ++next) {
      const Follower& follower = hand.followers[next];
      turn(follower.joint, hand.joints.size() + next, follower.angle(q));
    }
  }
}

/// Returns the columns of the joints, with those of the first followers added to their leaders'.
template <typename Column>
FingerJacobian coupled_columns(const Hand& hand, const Fingertip& tip, int followers, const Column& column) {
  FingerJacobian J = FingerJacobian::Zero(3, std::max(4, tip.joints));
  for (int j = 0; j < tip.joints; ++j) J.col(j) = column(tip.first_joint + j);
  for (int i = tip.first_follower; i < tip.first_follower + followers; ++i) {
    const Follower& follower = hand.followers[i];
    J.col(follower.leader - tip.first_joint) += follower.ratio * column(hand.joints.size() + i);
  }
  return J;
}

[[gnu::noinline]] FingerJacobian coupled_jacobian(const Hand& hand, const HandPose& pose, const Fingertip& tip,
                                                  int followers, const Vector3d& point_m) {
  return coupled_columns(hand, tip, followers,
                         [&](std::size_t i) -> Vector3d { return joint_column(pose, static_cast<int>(i), point_m); });
}

[[gnu::noinline]] void add_coupled_gravity(const Hand& hand, const HandPose& pose, const Segment& segment,
                                           const Isometry3d& X_WS, const Vector3d& gravity, JointVector& g) {
  const Fingertip& tip = hand.fingertips[segment.finger];
  const FingerJacobian J = coupled_jacobian(hand, pose, tip, segment.followers, X_WS * segment.com_m);
  for (int j = 0; j < segment.joints; ++j) g[tip.first_joint + j] -= J.col(j).dot(segment.mass_kg * gravity);
}

}  // namespace

Hand mirrored(Hand hand) {
  const auto mirror = [](Vector3d& v) { v.z() = -v.z(); };
  hand.mirrored = !hand.mirrored;
  const auto mirror_joint = [&](Joint& joint) {
    mirror(joint.origin_m);
    mirror(joint.axis);
    joint.axis = -joint.axis;  // of a turn that is mirrored
  };
  for (Joint& joint : hand.joints) mirror_joint(joint);
  for (Follower& follower : hand.followers) mirror_joint(follower.joint);
  for (Segment& segment : hand.segments) {
    mirror(segment.com_m);
    const Eigen::DiagonalMatrix<double, 3> M(1.0, 1.0, -1.0);
    segment.X_WS_0.linear() = M * segment.X_WS_0.linear() * M;
    segment.X_WS_0.translation().z() *= -1.0;
  }
  for (Fingertip& tip : hand.fingertips) {
    mirror(tip.centre_m);
    mirror(tip.normal);
    if (tip.shape) {
      const Eigen::DiagonalMatrix<double, 3> M(1.0, 1.0, -1.0);
      tip.shape->axes = M * tip.shape->axes * M;
    }
  }
  for (Muscle& muscle : hand.muscles) {
    for (MuscleCrossing& crossing : muscle.crossings) {
      mirror(crossing.insertion_m);
      mirror(crossing.pull);
    }
  }
  return hand;
}

void forward_kinematics(const Hand& hand, const JointVector& q, HandPose& pose) {
  pose.q = q;
  // chain[k][j]: the displacement that the first j joints of finger k make.
  std::array<FingerChain, kMaxFingers> chain;
  for (int k = 0; k < hand.fingers(); ++k) {
    if (hand.slides) {
      slide_kinematics(hand, q, hand.fingertips[k], chain[k], pose);
      continue;
    }
    if (hand.fingertips[k].followers > 0) {
      coupled_kinematics(hand, q, hand.fingertips[k], chain[k], pose);
      continue;
    }
    chain[k][0].setIdentity();
    for (int j = 0; j < hand.fingertips[k].joints; ++j) {
      const int i = hand.fingertips[k].first_joint + j;
      const Joint& joint = hand.joints[i];
      pose.origin_m[i] = chain[k][j] * joint.origin_m;
      pose.axis[i] = chain[k][j].linear() * joint.axis;
      // It turns about the joint, which stays where it is.
      chain[k][j + 1].linear() = chain[k][j].linear() * AngleAxisd(q[i], joint.axis).toRotationMatrix();
      chain[k][j + 1].translation() = pose.origin_m[i] - chain[k][j + 1].linear() * joint.origin_m;
    }
  }
  pose.segments.resize(hand.segments.size());
  for (std::size_t s = 0; s < hand.segments.size(); ++s) {
    const Segment& segment = hand.segments[s];
    pose.segments[s] = chain[segment.finger][segment.joints + segment.followers] * segment.X_WS_0;
  }
}

FingerJacobian finger_jacobian(const Hand& hand, const HandPose& pose, int finger, const Vector3d& point_m) {
  const Fingertip& tip = hand.fingertips[finger];
  if (hand.slides) return slide_jacobian(pose, tip);
  if (tip.followers > 0) return coupled_jacobian(hand, pose, tip, tip.followers, point_m);
  FingerJacobian J(3, std::max(4, tip.joints));
  if (tip.joints == 4) {  // Nearly all fingers: unrolled.
    for (int j = 0; j < 4; ++j) J.col(j) = joint_column(pose, tip.first_joint + j, point_m);
    return J;
  }
  J.setZero();
  for (int j = 0; j < tip.joints; ++j) J.col(j) = joint_column(pose, tip.first_joint + j, point_m);
  return J;
}

FingerJacobian segment_jacobian(const Hand& hand, const HandPose& pose, const Segment& segment,
                                const Vector3d& point_m) {
  const Fingertip& tip = hand.fingertips[segment.finger];
  return tip.followers > 0 ? coupled_jacobian(hand, pose, tip, segment.followers, point_m)
                           : finger_jacobian(hand, pose, segment.finger, point_m);
}

FingerJacobian turning_axes(const Hand& hand, const HandPose& pose, int finger) {
  const Fingertip& tip = hand.fingertips[finger];
  if (hand.slides) return FingerJacobian::Zero(3, std::max(4, tip.joints));
  return coupled_columns(hand, tip, tip.followers, [&](std::size_t i) -> Vector3d { return pose.axis[i]; });
}

double dot(const FingerVector& a, const FingerVector& b) {
  const double four = a.head<4>().dot(b.head<4>());
  return a.size() > 4 ? four + a[4] * b[4] : four;
}

Vector3d velocity(const FingerJacobian& J, const FingerVector& speeds) {
  Vector3d v = J.leftCols<4>() * speeds.head<4>();
  if (J.cols() > 4) v += J.col(4) * speeds[4];
  return v;
}

Matrix3d squared(const FingerJacobian& J) {
  Matrix3d JJ = J.leftCols<4>() * J.leftCols<4>().transpose();
  if (J.cols() > 4) JJ += J.col(4) * J.col(4).transpose();
  return JJ;
}

JointVector gravity_torques(const Hand& hand, const HandPose& pose, const Vector3d& gravity) {
  JointVector g = hand.at_zero();
  for (std::size_t s = 0; s < hand.segments.size(); ++s) {
    const Segment& segment = hand.segments[s];
    if (segment.joints == 0) continue;
    const Fingertip& tip = hand.fingertips[segment.finger];
    if (tip.followers > 0) {
      add_coupled_gravity(hand, pose, segment, pose.segments[s], gravity, g);
      continue;
    }
    if (hand.slides) {
      for (int i = tip.first_joint; i < tip.first_joint + segment.joints; ++i) {
        g[i] -= pose.axis[i].dot(segment.mass_kg * gravity);
      }
      continue;
    }
    const Vector3d com_m = pose.segments[s] * segment.com_m, weight_N = segment.mass_kg * gravity;
    for (int i = tip.first_joint; i < tip.first_joint + segment.joints; ++i) {
      g[i] -= joint_column(pose, i, com_m).dot(weight_N);
    }
  }
  return g;
}

}  // namespace thenar
