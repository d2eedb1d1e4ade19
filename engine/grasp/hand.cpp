#include "engine/grasp/hand.h"

namespace thenar {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

Hand mirrored(Hand hand) {
  const auto mirror = [](Vector3d& v) { v.z() = -v.z(); };
  hand.mirrored = !hand.mirrored;
  for (Joint& joint : hand.joints) {
    mirror(joint.origin_m);
    mirror(joint.axis);
    joint.axis = -joint.axis;  // of a turn that is mirrored
  }
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
  // chain[k][j]: the displacement that the first j joints of finger k make.
  std::array<std::array<Isometry3d, kMaxFingerJoints + 1>, kMaxFingers> chain;
  for (int k = 0; k < hand.fingers(); ++k) {
    chain[k][0].setIdentity();
    for (int j = 0; j < hand.fingertips[k].joints; ++j) {
      const int i = hand.fingertips[k].first_joint + j;
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

FingerJacobian finger_jacobian(const Hand& hand, const HandPose& pose, int finger, const Vector3d& point_m) {
  const Fingertip& tip = hand.fingertips[finger];
  FingerJacobian J(3, std::max(4, tip.joints));
  const auto column = [&](int j) {
    const int i = tip.first_joint + j;
    J.col(j) = pose.axis[i].cross(point_m - pose.origin_m[i]);
  };
  if (tip.joints == 4) {  // Of nearly all fingers: unrolled.
    for (int j = 0; j < 4; ++j) column(j);
    return J;
  }
  J.setZero();
  for (int j = 0; j < tip.joints; ++j) column(j);
  return J;
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
    const FingerJacobian J = finger_jacobian(hand, pose, segment.finger, pose.segments[s] * segment.com_m);
    const int first = hand.fingertips[segment.finger].first_joint;
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
