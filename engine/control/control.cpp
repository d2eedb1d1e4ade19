// SPDX-License-Identifier: Apache-2.0
#include "engine/control/control.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/grasp/frame.h"
#include "engine/grasp/pulp_touch.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Returns the minors of J: a vector normal to its rows. Where J is singular they vanish but for rounding.
Eigen::Vector4d normal_to_rows(const Eigen::Matrix<double, 3, 4>& J) {
  const auto minor = [&](int a, int b, int c) { return J.col(a).dot(J.col(b).cross(J.col(c))); };
  return {minor(1, 2, 3), -minor(0, 2, 3), minor(0, 1, 3), -minor(0, 1, 2)};
}

/// Returns the ball that approximates a pulp where it is nearest to the object, its centre in the world.
PulpBall pulp_ball(const Model& model, const Isometry3d& X_WF, const Snapshot& snapshot, int finger) {
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  PulpBall ball = touching_ball(tip, model.object, snapshot.X_WO.inverse() * X_WF);
  ball.centre_m = X_WF * ball.centre_m;
  return ball;
}

}  // namespace

Matrix3d damped(Matrix3d JJ) {
  constexpr double kNear = 1e-3;  // of the largest volume that columns of such lengths could span
  const double scale = JJ.trace() / 3.0, volume = std::sqrt(std::max(0.0, JJ.determinant()) / std::pow(scale, 3));
  if (volume < kNear) JJ.diagonal().array() += kNear * scale * std::pow(1.0 - volume / kNear, 2);
  return JJ;
}

Vector6d PosePid::update(const Vector6d& error, double period_s, double share) {
  integral_ += period_s * share * error;
  const Vector6d rate = started_ ? Vector6d((error - last_error_) / period_s) : Vector6d::Zero();
  last_error_ = error;
  started_ = true;
  const auto act = [&](const PidGains& gains, auto e, auto integral, auto e_rate) {
    return Eigen::Vector3d(share * (gains.p * e + gains.d * e_rate) + gains.i * integral);
  };
  Vector6d wrench;
  wrench.head<3>() = act(position_, error.head<3>(), integral_.head<3>(), rate.head<3>());
  wrench.tail<3>() = act(rotation_, error.tail<3>(), integral_.tail<3>(), rate.tail<3>());
  return wrench;
}

Vector6d PosePid::held() const {
  Vector6d wrench;
  wrench << position_.i * integral_.head<3>(), rotation_.i * integral_.tail<3>();
  return wrench;
}

// Flat, as add_fine_contacts: else Eigen's products are calls of copies that other rooms may have made slower.
[[gnu::flatten]] GraspContact finger_contact(const Model& model, const HandPose& pose, const Snapshot& snapshot,
                                             int finger) {
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Isometry3d& X_WF = pose.distal(model.scene.hand, finger);
  const FingerLoad& load = snapshot.load[finger];
  Vector3d point = load.centre_m, n = load.normal;
  if (load.normal_N <= 0.0) {
    const PulpBall ball = pulp_ball(model, X_WF, snapshot, finger);
    const auto nearest =
        model.object.distance(snapshot.X_WO.inverse() * ball.centre_m, std::numeric_limits<double>::infinity());
    // Normals that cancel leave no direction but the one to the object's origin.
    n = nearest ? Vector3d(snapshot.X_WO.linear() * -nearest->normal)
                : (snapshot.X_WO.translation() - ball.centre_m).normalized();
    point = ball.centre_m + ball.radius_m * n;
  }
  return {point, X_WF.linear() * contact_frame(tip.normal, X_WF.linear().transpose() * n)};
}

double finger_gap_m(const Model& model, const HandPose& pose, const Snapshot& snapshot, int finger) {
  if (snapshot.load[finger].normal_N > 0.0) return 0.0;
  const Isometry3d& X_WF = pose.distal(model.scene.hand, finger);
  const PulpBall ball = pulp_ball(model, X_WF, snapshot, finger);
  const auto nearest =
      model.object.distance(snapshot.X_WO.inverse() * ball.centre_m, std::numeric_limits<double>::infinity());
  return nearest ? nearest->distance_m - ball.radius_m : 0.0;
}

ForceFilter::ForceFilter(const Model& model)
    : stiffness_(model.scene.control->pulp_normal_N_per_m, model.scene.control->pulp_tangential_N_per_m,
                 model.scene.control->pulp_tangential_N_per_m),
      relaxation_s_(model.fingers()),
      y_C_(FingerForces::Zero(3, model.fingers())) {
  for (std::size_t k = 0; k < model.pulps.size(); ++k) relaxation_s_[k] = model.pulps[k].material.relaxation_s;
}

FingerForces ForceFilter::update(const PerFinger<GraspContact>& contacts, const FingerForces& error, double period_s) {
  FingerForces y(3, y_C_.cols());
  for (Eigen::Index k = 0; k < y.cols(); ++k) {
    const double lag = relaxation_s_[k] / period_s;
    const Vector3d error_C = contacts[k].axes.transpose() * error.col(k);
    y_C_.col(k) = (lag * y_C_.col(k) + error_C.cwiseQuotient(stiffness_)) / (1.0 + lag);
    y.col(k) = contacts[k].axes * y_C_.col(k);
  }
  return y;
}

double lag_s(const Scene& scene) {
  // Muscles that relax are late by their time constant, longest without activation.
  double lag = scene.control_delay_s + scene.control->feedback_delay_s;
  if (scene.has_muscles() && scene.control->muscles->activation)
    lag += 2.0 * scene.control->muscles->activation->fall_s;
  return lag;
}

double force_gain(const Scene& scene, int finger) {
  // Sampled with a period and a delay, the loop is stable up to about 2 b / (period + delay). A third of that settles
  // within two periods; with a delay the lag behind a moving target grows, and more than half of it errs less.
  const double period_s = scene.control_period_s, delay_s = lag_s(scene);
  return scene.control->gain.value_or(2.0 * scene.viscosity(finger) *
                                      std::min(0.3 / period_s, 0.6 / (period_s + delay_s)));
}

FingerVector posture_torques(const FingerJacobian& J, int joints, double stiffness, const FingerVector& error) {
  constexpr double kSingular = 1e-9;
  const double size = std::pow(J.norm(), 3);
  // Four of five joints are free in one direction, five in the plane that all such directions span.
  std::array<FingerVector, kMaxFingerJoints> free;
  const int fours = joints == 4 ? 1 : joints == 5 ? 5 : 0;
  for (int without = 0; without < fours; ++without) {
    Eigen::Matrix<double, 3, 4> four = J.leftCols<4>();
    for (int j = 4 - without; j < 4 && fours > 1; ++j) four.col(j) = J.col(j + 1);
    const Eigen::Vector4d z = normal_to_rows(four);
    FingerVector& all = free[without] = FingerVector::Zero(J.cols());
    for (int j = 0; j < 4; ++j) all[fours > 1 && j >= 4 - without ? j + 1 : j] = z[j];
  }
  FingerVector torques = FingerVector::Zero(J.cols());
  for (int direction = 3; direction < joints; ++direction) {
    const FingerVector z = *std::max_element(free.begin(), free.begin() + fours,
                                             [](const auto& a, const auto& b) { return dot(a, a) < dot(b, b); });
    if (!(std::sqrt(dot(z, z)) > kSingular * size)) return FingerVector::Zero(J.cols());
    torques += stiffness * z * (dot(z, error) / dot(z, z));
    for (int i = 0; i < fours; ++i) free[i] -= z * (dot(z, free[i]) / dot(z, z));
  }
  return torques;
}

JointVector desired_torques(const Model& model, const JointVector& q, const HandPose& pose, const Vector3d& gravity,
                            const PerFinger<GraspContact>& contacts, const FingerForces& f_desired,
                            const FingerForces& y) {
  const Hand& hand = model.scene.hand;
  const bool feedforward = model.scene.control->law == ControlLaw::kFeedforward;
  JointVector tau = hand.at_zero();
  if (feedforward) tau = gravity_torques(hand, pose, gravity);
  for (int k = 0; k < model.fingers(); ++k) {
    const Fingertip& tip = hand.fingertips[k];
    const FingerJacobian J = finger_jacobian(hand, pose, k, contacts[k].point_m);
    const Vector3d pulled = damped(squared(J)).ldlt().solve(y.col(k));
    FingerVector tau_k = hand.of_finger(k, tau);
    tau_k.head<4>() += force_gain(model.scene, k) * J.leftCols<4>().transpose() * pulled;
    if (feedforward) tau_k.head<4>() += J.leftCols<4>().transpose() * f_desired.col(k);
    if (tip.joints > 4) {
      tau_k[4] +=
          force_gain(model.scene, k) * J.col(4).dot(pulled) + (feedforward ? J.col(4).dot(f_desired.col(k)) : 0.0);
    }
    if (const auto stiffness = model.scene.control->posture_Nm_per_rad) {
      const FingerVector error = hand.of_finger(k, model.scene.posture - q);
      FingerVector posture = posture_torques(J, tip.joints, *stiffness, error);
      // Where a joint moves others, too, its drag is larger: so the motion, not the torque, is along z.
      for (int j = 0; tip.followers > 0 && j < tip.joints; ++j) posture[j] *= hand.joints[tip.first_joint + j].drag;
      tau_k += posture;
    }
    tau.segment(tip.first_joint, tip.joints) = tau_k.head(tip.joints);
  }
  return tau;
}

JointVector joints_with_object(const Hand& hand, const HandPose& pose, const PerFinger<GraspContact>& contacts,
                               const Vector3d& centre_m, const Vector6d& motion) {
  JointVector dq = hand.at_zero();
  for (int k = 0; k < hand.fingers(); ++k) {
    const Fingertip& tip = hand.fingertips[k];
    const FingerJacobian J = finger_jacobian(hand, pose, k, contacts[k].point_m);
    const Vector3d at = motion.head<3>() + motion.tail<3>().cross(contacts[k].point_m - centre_m);
    const Vector3d pulled = damped(squared(J)).ldlt().solve(at);
    for (int j = 0; j < tip.joints; ++j) dq[tip.first_joint + j] = J.col(j).dot(pulled);
  }
  return dq;
}

JointVector viscous_torques(const Model& model, const HandPose& pose, const PerFinger<GraspContact>& contacts,
                            const Vector3d& centre_m, const Vector6d& velocity) {
  const Hand& hand = model.scene.hand;
  JointVector tau = joints_with_object(hand, pose, contacts, centre_m, velocity);
  for (int k = 0; k < model.fingers(); ++k) {
    const Fingertip& tip = hand.fingertips[k];
    for (int j = tip.first_joint; j < tip.first_joint + tip.joints; ++j) {
      tau[j] = model.scene.viscosity(k) * hand.joints[j].drag * tau[j];
    }
  }
  return tau;
}

FingerVector joints_with_point(const Hand& hand, const HandPose& pose, const PerFinger<GraspContact>& contacts, int k,
                               const Vector3d& velocity) {
  const FingerJacobian J = finger_jacobian(hand, pose, k, contacts[k].point_m);
  const Vector3d pulled = damped(squared(J)).ldlt().solve(velocity);
  FingerVector dq = FingerVector::Zero(J.cols());
  for (int j = 0; j < hand.fingertips[k].joints; ++j) dq[j] = J.col(j).dot(pulled);
  return dq;
}

double predicted_paper_law_error(const Model& model, const HandPose& pose, const PerFinger<GraspContact>& contacts,
                                 const FingerForces& f_desired) {
  const ControlSettings& control = *model.scene.control;
  const Vector3d stiffness(control.pulp_normal_N_per_m, control.pulp_tangential_N_per_m,
                           control.pulp_tangential_N_per_m);
  double sum = 0.0;
  for (int k = 0; k < model.fingers(); ++k) {
    const FingerJacobian J = finger_jacobian(model.scene.hand, pose, k, contacts[k].point_m);
    const Matrix3d& E = contacts[k].axes;
    const Matrix3d S = E * stiffness.asDiagonal() * E.transpose() * squared(J) / force_gain(model.scene, k);
    const Vector3d error = (Matrix3d::Identity() + S).inverse() * (S * f_desired.col(k));
    sum += error.norm() / f_desired.col(k).norm();
  }
  return sum / model.fingers();
}

}  // namespace thenar
