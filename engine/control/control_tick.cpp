// SPDX-License-Identifier: Apache-2.0
#include "engine/control/control_tick.h"

#include <algorithm>

#include "engine/control/control_period.h"
#include "engine/grasp/stopwatch.h"

namespace thenar {

using Eigen::Index;

namespace {

/// Returns tau, the drive of the joints in this period.
JointVector joint_torques(ControlPeriod& period) {
  const Scene& scene = period.model.scene;
  if (!scene.control && !period.controller.own.torques) return scene.torques.value_or(scene.hand.at_zero());
  if (!scene.has_muscles()) return period.torques();
  const Eigen::VectorXd& f = period.muscle_forces();
  JointVector tau = scene.muscles_act() ? muscle_torques(scene.hand, period.controller.bellies, f)
                                        : JointVector(period.moment_arms() * f);
  if (period.has_torques()) {
    period.report.muscle_residual_Nm = (tau - period.report.torques_desired_Nm).cwiseAbs().maxCoeff();
  }
  return tau;
}

/// Fills the frame's data of the muscles.
void hand_over_muscles(const Model& model, const Snapshot& snapshot, const Eigen::Vector3d& gravity,
                       const Controller& controller, Frame& frame) {
  frame.bellies = controller.bellies;
  frame.q = snapshot.q;
  frame.q_rest = controller.q_rest;
  for (int k = 0; k < model.fingers(); ++k) {
    frame.turning[k] = gravity_stiffness(model.scene.hand, controller.pose, k, gravity);
  }
}

/// Returns the newest snapshot, or the known one with control.feedback_delay.
const Snapshot& seen_by_laws(const Model& model, const Snapshot& snapshot, Controller& controller) {
  if (!controller.afference.is_needed()) return snapshot;
  controller.afference.add(snapshot, controller.f_desired);
  const std::int64_t delay = ticks_of(model, model.scene.control->feedback_delay_s);
  return delay > 0 ? controller.afference.at(snapshot.tick - delay).snapshot : snapshot;
}

void go_on_with_task(const Model& model, const Snapshot& seen, Controller& controller, ControlReport& report) {
  controller.task->update(model, controller.pose, seen, controller.f_desired);
  report.task = controller.task->report();
  // The reflex does not respond to loads of fingers that move alone.
  const double from_N = model.scene.control->internal_force_N;
  for (ContactGrip& grip : report.reflex.grips) {
    const double answer_N = report.task.holds ? grip.internal_force_N - from_N : 0.0;
    grip.internal_force_N = std::max(0.0, report.task.squeeze_N + answer_N);
  }
}

}  // namespace

ControlReport control_tick(const Model& model, const ContactSnapshot& snapshot, Controller& controller, Frame& frame) {
  const Scene& scene = model.scene;
  ControlReport report(scene.hand);
  Stopwatch total;
  const Snapshot& seen = seen_by_laws(model, snapshot, controller);
  // Simulated time: late ticks are further apart, and steps that slip do not count.
  if (controller.sequence > 0) {
    const auto steps = std::max<std::int64_t>(1, snapshot.tick - controller.last_tick);
    controller.period_s = static_cast<double>(steps) * scene.step_s;
  }
  controller.last_tick = snapshot.tick;

  const auto fill_geometry = [&] {
    frame.tick = snapshot.tick;
    frame.X_WO = snapshot.X_WO;
    for (int k = 0; k < model.fingers(); ++k) frame.X_WF[k] = controller.pose.distal(scene.hand, k);
    Stopwatch stage;
    find_frame_contacts(model, controller.pose, snapshot, controller.search, frame);
    report.find_s = stage.lap();
    for (std::size_t k = 0; k < model.pulps.size(); ++k) {
      frame.softness[k] = softness(model.pulps[k].material, snapshot.load[k].normal_N);
    }
    controller.compliance.update(model, frame);
    report.factors_s = stage.lap();
  };
  if (scene.muscles_act()) {
    // The actual ones, not the known ones.
    forward_kinematics(scene.hand, snapshot.q, controller.pose);
    find_bellies(scene.hand, controller.pose, controller.bellies);
  }
  controller.looks = controller.stiffness && (!controller.task || controller.task->report().holds);
  if (controller.looks) {
    fill_geometry();
    controller.stiffness->look(model, frame, controller.pose, snapshot);
    report.stiffness.squeeze_N = controller.stiffness->squeeze_N();
  }
  if (!scene.muscles_act() || &seen != &snapshot) forward_kinematics(scene.hand, seen.q, controller.pose);
  if (controller.reflex) {
    const Sensed& felt = controller.afference.at(snapshot.tick - ticks_of(model, scene.fingertips->touch->delay_s));
    report.reflex = controller.reflex->update(model, felt, snapshot, controller.f_desired, controller.period_s);
  }
  if (controller.task) go_on_with_task(model, seen, controller, report);
  report.centre_m = seen.X_WO.translation();
  ControlPeriod period(model, seen, snapshot.tick, controller, report);
  const JointVector tau = joint_torques(period);
  if (controller.afference.is_needed()) controller.afference.set_desired(controller.f_desired);
  if (&seen != &snapshot) forward_kinematics(scene.hand, snapshot.q, controller.pose);

  const double now_s = static_cast<double>(snapshot.tick) * scene.step_s;
  frame.sequence = controller.sequence++;
  const Eigen::Vector3d gravity = model.gravity(now_s);
  frame.torque_Nm = tau - gravity_torques(scene.hand, controller.pose, gravity);
  if (scene.has_muscles()) frame.muscle_N = controller.f_muscle;
  if (scene.muscles_act()) hand_over_muscles(model, snapshot, gravity, controller, frame);
  frame.wrench = model.external_wrench(now_s, snapshot.X_WO);
  if (controller.task) frame.arm = controller.task->arm();
  if (!controller.looks) fill_geometry();
  report.total_s = total.lap();
  return report;
}

}  // namespace thenar
