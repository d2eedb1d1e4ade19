#include "engine/grasp/hand.h"

namespace thenar {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

void forward_kinematics(const Hand& hand, const JointVector& q, HandPose& pose) {
  // chain[k][j]: the displacement that the first j joints of finger k make.
  std::array<std::array<Isometry3d, kJointsPerFinger + 1>, kFingers> chain;
  for (int k = 0; k < kFingers; ++k) {
    chain[k][0].setIdentity();
    for (int j = 0; j < kJointsPerFinger; ++j) {
      const int i = k * kJointsPerFinger + j;
      const Joint& joint = hand.joints[i];
      pose.origin_m[i] = chain[k][j] * joint.origin_m;
      pose.axis[i] = chain[k][j].linear() * joint.axis;
      const Translation3d to_joint(joint.origin_m);
      chain[k][j + 1] = chain[k][j] * to_joint * AngleAxisd(q[i], joint.axis) * to_joint.inverse();
    }
  }
  pose.segments.resize(hand.segments.size());
  for (std::size_t s = 0; s < hand.segments.size(); ++s) {
    const Segment& segment = hand.segments[s];
    pose.segments[s] = chain[segment.finger][segment.joints] * segment.X_WS_0;
  }
}

FingerJacobian finger_jacobian(const HandPose& pose, int finger, const Vector3d& point_m) {
  FingerJacobian J;
  for (int j = 0; j < kJointsPerFinger; ++j) {
    const int i = finger * kJointsPerFinger + j;
    J.col(j) = pose.axis[i].cross(point_m - pose.origin_m[i]);
  }
  return J;
}

JointVector gravity_torques(const Hand& hand, const HandPose& pose, const Vector3d& gravity) {
  JointVector g = JointVector::Zero();
  for (std::size_t s = 0; s < hand.segments.size(); ++s) {
    const Segment& segment = hand.segments[s];
    const FingerJacobian J = finger_jacobian(pose, segment.finger, pose.segments[s] * segment.com_m);
    const int first = segment.finger * kJointsPerFinger;
    g.segment(first, segment.joints) -= J.leftCols(segment.joints).transpose() * (segment.mass_kg * gravity);
  }
  return g;
}

void moment_arms(const Hand& hand, const HandPose& pose, Eigen::Ref<Eigen::MatrixXd> H) {
  H.setZero();
  for (std::size_t m = 0; m < hand.muscles.size(); ++m) {
    for (const MuscleCrossing& crossing : hand.muscles[m].crossings) {
      const Vector3d M = pose.segments[crossing.insertion_segment] * crossing.insertion_m;
      const Isometry3d& X_pull = pose.segments[crossing.pull_segment];
      const Vector3d pull =
          crossing.pull_is_point ? Vector3d(X_pull * crossing.pull - M) : Vector3d(X_pull.linear() * crossing.pull);
      const Vector3d D = pull.normalized();
      for (const int i : crossing.joints) {
        H(i, static_cast<Eigen::Index>(m)) += crossing.share * (M - pose.origin_m[i]).cross(D).dot(pose.axis[i]);
      }
    }
  }
}

}  // namespace thenar
