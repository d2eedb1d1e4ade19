#include "engine/grasp/control.h"

#include <cmath>
#include <limits>

#include "engine/grasp/frame.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector6d pose_error(const Isometry3d& X_WT, const Isometry3d& X_WO) {
  const Eigen::AngleAxisd turn(Matrix3d(X_WT.linear() * X_WO.linear().transpose()));
  Vector6d error;
  error << X_WT.translation() - X_WO.translation(), turn.angle() * turn.axis();
  return error;
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

GraspContact finger_contact(const Model& model, const HandPose& pose, const Snapshot& snapshot, int finger) {
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Isometry3d& X_WF = pose.distal(model.scene.hand, finger);
  const FingerLoad& load = snapshot.load[finger];
  Vector3d point = load.centre_m, n = load.normal;
  if (load.normal_N <= 0.0) {
    const Vector3d centre = X_WF * tip.centre_m;
    const auto nearest =
        model.object.distance(snapshot.X_WO.inverse() * centre, std::numeric_limits<double>::infinity());
    // Normals that cancel leave no direction but the one to the object's origin.
    n = nearest ? Vector3d(snapshot.X_WO.linear() * -nearest->normal)
                : (snapshot.X_WO.translation() - centre).normalized();
    point = centre + tip.radius_m * n;
  }
  return {point, X_WF.linear() * contact_frame(tip.normal, X_WF.linear().transpose() * n)};
}

double finger_gap_m(const Model& model, const HandPose& pose, const Snapshot& snapshot, int finger) {
  if (snapshot.load[finger].normal_N > 0.0) return 0.0;
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Vector3d centre = pose.distal(model.scene.hand, finger) * tip.centre_m;
  const auto nearest = model.object.distance(snapshot.X_WO.inverse() * centre, std::numeric_limits<double>::infinity());
  return nearest ? nearest->distance_m - tip.radius_m : 0.0;
}

ForceFilter::ForceFilter(const Model& model)
    : stiffness_(model.scene.control->pulp_normal_N_per_m, model.scene.control->pulp_tangential_N_per_m,
                 model.scene.control->pulp_tangential_N_per_m),
      relaxation_s_(model.scene.fingertips ? model.scene.fingertips->material.relaxation_s : 0.0) {}

FingerForces ForceFilter::update(const std::array<GraspContact, kFingers>& contacts, const FingerForces& error,
                                 double period_s) {
  FingerForces y;
  const double lag = relaxation_s_ / period_s;
  for (int k = 0; k < kFingers; ++k) {
    const Vector3d error_C = contacts[k].axes.transpose() * error.col(k);
    y_C_.col(k) = (lag * y_C_.col(k) + error_C.cwiseQuotient(stiffness_)) / (1.0 + lag);
    y.col(k) = contacts[k].axes * y_C_.col(k);
  }
  return y;
}

double force_gain(const Scene& scene) {
  // Sampled with a period and a delay, the loop is stable up to about 2 b / (period + delay). A third of that settles
  // within two periods; with a delay the lag behind a moving target grows, and more than half of it errs less.
  const double period_s = scene.control_period_s;
  return scene.control->gain.value_or(2.0 * scene.joint_viscosity *
                                      std::min(0.3 / period_s, 0.6 / (period_s + scene.control_delay_s)));
}

Eigen::Vector4d posture_torques(const FingerJacobian& J, double stiffness, const Eigen::Vector4d& error) {
  // The minors of J are a vector that is normal to its rows. Of a singular J they vanish but for rounding.
  constexpr double kSingular = 1e-9;
  const auto minor = [&](int a, int b, int c) { return J.col(a).dot(J.col(b).cross(J.col(c))); };
  const Eigen::Vector4d z(minor(1, 2, 3), -minor(0, 2, 3), minor(0, 1, 3), -minor(0, 1, 2));
  const double size = std::pow(J.norm(), 3);
  if (!(z.norm() > kSingular * size)) return Eigen::Vector4d::Zero();
  return stiffness * z * (z.dot(error) / z.squaredNorm());
}

JointVector desired_torques(const Model& model, const JointVector& q, const HandPose& pose,
                            const std::array<GraspContact, kFingers>& contacts, const FingerForces& f_desired,
                            const FingerForces& y) {
  const bool feedforward = model.scene.control->law == ControlLaw::kFeedforward;
  const double K = force_gain(model.scene);
  JointVector tau = JointVector::Zero();
  if (feedforward) tau = gravity_torques(model.scene.hand, pose, model.scene.gravity);
  for (int k = 0; k < kFingers; ++k) {
    const FingerJacobian J = finger_jacobian(pose, k, contacts[k].point_m);
    auto tau_k = tau.segment<kJointsPerFinger>(kJointsPerFinger * k);
    tau_k += K * J.transpose() * (J * J.transpose()).ldlt().solve(y.col(k));
    if (feedforward) tau_k += J.transpose() * f_desired.col(k);
    if (const auto stiffness = model.scene.control->posture_Nm_per_rad) {
      const JointVector error = model.scene.posture - q;
      tau_k += posture_torques(J, *stiffness, error.segment<kJointsPerFinger>(kJointsPerFinger * k));
    }
  }
  return tau;
}

double predicted_paper_law_error(const Model& model, const HandPose& pose,
                                 const std::array<GraspContact, kFingers>& contacts, const FingerForces& f_desired) {
  const ControlSettings& control = *model.scene.control;
  const Vector3d stiffness(control.pulp_normal_N_per_m, control.pulp_tangential_N_per_m,
                           control.pulp_tangential_N_per_m);
  double sum = 0.0;
  for (int k = 0; k < kFingers; ++k) {
    const FingerJacobian J = finger_jacobian(pose, k, contacts[k].point_m);
    const Matrix3d& E = contacts[k].axes;
    const Matrix3d S = E * stiffness.asDiagonal() * E.transpose() * J * J.transpose() / force_gain(model.scene);
    const Vector3d error = (Matrix3d::Identity() + S).inverse() * (S * f_desired.col(k));
    sum += error.norm() / f_desired.col(k).norm();
  }
  return sum / kFingers;
}

}  // namespace thenar
