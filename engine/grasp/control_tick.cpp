#include "engine/grasp/control_tick.h"

#include <algorithm>
#include <cmath>

#include "engine/grasp/compliance.h"
#include "engine/grasp/stopwatch.h"

namespace thenar {

using Eigen::Index;

namespace {

// Grasp forces may be so many times what is asked for, moments taken at this lever.
constexpr double kMostForce = 100.0, kLeastLever_m = 1e-2;

void solve_grasp(const Model& model, const Snapshot& snapshot, Controller& controller, ControlReport& report) {
  const Scene& scene = model.scene;
  const double time_s = static_cast<double>(snapshot.tick) * scene.step_s;
  const Eigen::Isometry3d X_WT = snapshot.X_WT.value_or(model.target(time_s));
  // In a hold nothing that is asked for acts. The error that has gathered there comes back as slowly as the drive does.
  const double fade = std::exp(-controller.period_s / kResume_s);
  controller.acting_share = snapshot.held ? 0.0 : 1.0 - fade * (1.0 - controller.acting_share);
  const Vector6d D =
      controller.pid->update(pose_error(X_WT, snapshot.X_WO), controller.period_s, controller.acting_share);
  report.wrench_desired = D - model.weight(snapshot.X_WO);
  for (int k = 0; k < model.fingers(); ++k) report.contacts[k] = finger_contact(model, controller.pose, snapshot, k);
  const GraspProblem problem = grasp_problem(scene, report, snapshot.X_WO.translation());
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3 * kMaxFingers, 1> f = controller.f_desired;
  report.grasp = solve_grasp_forces(problem, f).status;
  // Contacts that hardly resist some moment take forces that no finger has: that is no grasp.
  const double asked_N = scene.control->internal_force_N + report.wrench_desired.head<3>().norm() +
                         report.wrench_desired.tail<3>().norm() / kLeastLever_m;
  if (report.grasp == GraspStatus::kOptimal && f.norm() > kMostForce * asked_N) report.grasp = GraspStatus::kInfeasible;
  if (report.grasp == GraspStatus::kOptimal) {
    controller.f_desired = f;
  } else {
    for (int k = 0; k < model.fingers(); ++k) report.gap_m[k] = finger_gap_m(model, controller.pose, snapshot, k);
  }
  report.f_desired = controller.f_desired.reshaped(3, model.fingers());
}

JointVector drive(const Model& model, const Snapshot& snapshot, Controller& controller, ControlReport& report) {
  FingerForces error(3, model.fingers());
  for (int k = 0; k < model.fingers(); ++k) error.col(k) = report.f_desired.col(k) - snapshot.load[k].force_N;
  const FingerForces y = controller.filter->update(report.contacts, error, controller.period_s);
  return desired_torques(model, snapshot.q, controller.pose, report.contacts, report.f_desired, y);
}

/// tau = H f_m: the torques that the muscles give for those asked for.
JointVector muscle_torques(const Model& model, const JointVector& tau_desired, Controller& controller,
                           ControlReport& report) {
  moment_arms(model.scene.hand, controller.pose, controller.H);
  report.muscle = solve_muscle_forces({controller.H, tau_desired}, controller.f_muscle).status;
  JointVector tau = controller.H * controller.f_muscle;
  report.muscle_residual_Nm = (tau - tau_desired).cwiseAbs().maxCoeff();
  return tau;
}

}  // namespace

Controller::Controller(const Model& model)
    : period_s(model.scene.control_period_s),
      f_desired(Eigen::VectorXd::Zero(3 * model.fingers())),
      f_muscle(Eigen::VectorXd::Zero(static_cast<Index>(model.scene.hand.muscles.size()))),
      H(static_cast<Index>(model.scene.hand.joints.size()), f_muscle.size()),
      search(model) {
  if (!model.scene.control) return;
  pid.emplace(model.scene.control->position, model.scene.control->rotation);
  filter.emplace(model);
}

GraspProblem grasp_problem(const Scene& scene, const ControlReport& report, const Eigen::Vector3d& centre_m) {
  return {.contacts = report.contacts,
          .centre_m = centre_m,
          .wrench = report.wrench_desired,
          .friction = scene.control->grasp_friction,
          .cone = scene.control->cone,
          .internal_force_N = scene.control->internal_force_N};
}

ControlReport control_tick(const Model& model, const Snapshot& snapshot, Controller& controller, Frame& frame) {
  const Scene& scene = model.scene;
  ControlReport report(scene.hand);
  Stopwatch total, stage;
  forward_kinematics(scene.hand, snapshot.q, controller.pose);
  // What has passed for the object: late ticks are further apart, and steps that slip do not count.
  if (controller.sequence > 0) {
    const auto steps = std::max<std::int64_t>(1, snapshot.tick - controller.last_tick);
    controller.period_s = static_cast<double>(steps) * scene.step_s;
  }
  controller.last_tick = snapshot.tick;

  JointVector tau = scene.torques.value_or(scene.hand.at_zero());
  if (scene.control) {
    stage.lap();
    solve_grasp(model, snapshot, controller, report);
    report.grasp_s = stage.lap();
    tau = drive(model, snapshot, controller, report);
    report.torques_desired_Nm = tau;
    stage.lap();
    if (scene.control->muscles) {
      tau = muscle_torques(model, tau, controller, report);
      report.muscle_s = stage.lap();
    }
  }

  frame.sequence = controller.sequence++;
  frame.tick = snapshot.tick;
  frame.X_WO = snapshot.X_WO;
  for (int k = 0; k < model.fingers(); ++k) frame.X_WF[k] = controller.pose.distal(scene.hand, k);
  frame.torque_Nm = tau - gravity_torques(scene.hand, controller.pose, scene.gravity);
  frame.wrench = model.external_wrench(static_cast<double>(snapshot.tick) * scene.step_s, snapshot.X_WO);
  stage.lap();
  find_frame_contacts(model, controller.pose, snapshot, controller.search, frame);
  report.find_s = stage.lap();
  for (std::size_t k = 0; k < model.pulps.size(); ++k) {
    frame.softness[k] = softness(model.pulps[k].material, snapshot.load[k].normal_N);
  }
  fill_kernels(model, frame);
  report.factors_s = stage.lap();
  report.total_s = total.lap();
  return report;
}

}  // namespace thenar
