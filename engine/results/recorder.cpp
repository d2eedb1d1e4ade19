// SPDX-License-Identifier: Apache-2.0
#include "engine/results/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Vector3d;

namespace {

NormalTangential split(const Vector3d& force, const Vector3d& n) {
  const double normal_N = force.dot(n);
  return {normal_N, (force - normal_N * n).norm()};
}

/// Where the object is to be. What nobody holds is there.
Eigen::Isometry3d target_of(const Model& model, const Snapshot& state, const TaskReport& task, double time_s) {
  if (state.X_WT) return *state.X_WT;
  if (!task.holds) return state.X_WO;
  return task.X_WT ? *task.X_WT : model.target(time_s);
}

void record_motion(const Model& model, const Snapshot& state, TickRecord& record) {
  const Eigen::Isometry3d& start = model.scene.object.X_WO;
  record.position_m = start.linear().transpose() * (state.X_WO.translation() - start.translation());
  record.target_m = start.linear().transpose() * (record.X_WT.translation() - start.translation());
  record.rotation_error_rad = pose_error(record.X_WT, state.X_WO).tail<3>().norm();
}

void record_forces(const Model& model, const Snapshot& state, const ControlReport& control, TickRecord& record) {
  for (int k = 0; k < model.fingers(); ++k) {
    const FingerLoad& load = state.load[k];
    record.force[k] = split(load.force_N, load.normal);
    record.desired_N[k].setZero();
    if (!control.has_forces) continue;
    record.desired_N[k] = control.f_desired.col(k);
    record.force_desired[k] = split(control.f_desired.col(k), control.contacts[k].axes.col(0));
    record.force_error_N[k] = (control.f_desired.col(k) - load.force_N).norm();
  }
}

}  // namespace

void record_control(const ControlReport& control, TickRecord& record) {
  record.controlled = true;
  record.find_s = control.find_s;
  record.factors_s = control.factors_s;
  record.grasp_s = control.grasp_s;
  record.muscle_s = control.muscle_s;
  record.control_s = control.total_s;
  record.grasp = control.grasp;
  record.muscle = control.muscle;
  record.muscle_residual_Nm = control.muscle_residual_Nm;
}

TickRecord tick_record(const Model& model, const Snapshot& after, const TickReport& contact,
                       const ControlReport& control) {
  TickRecord record(model.scene.hand);
  record.contact = contact;
  for (int k = 0; k < model.fingers(); ++k) {
    record.margin[k] = contact.patch[k].margin;
    record.sliding_share[k] = contact.patch[k].sliding_share;
    record.creep_m_per_s[k] = contact.patch[k].creep_m_per_s;
  }
  record.touch = after.touch;
  record.reflex = control.reflex;
  // All ticks of a frame have the report of its control tick: the first one keeps it, RunSums hands it on.
  if (contact.handed_over) record.stiffness = KnownStiffness::of(model.scene, control);
  record.time_s = static_cast<double>(after.tick) * model.scene.step_s;
  record.X_WO = after.X_WO;
  record.q_rad = after.q;
  record.load = after.load;
  if (control.torques_desired_Nm.size() > 0) record.torques_Nm = control.torques_desired_Nm;
  record.phase = control.task.phase;
  record.holds = control.task.holds;
  record.X_WT = target_of(model, after, control.task, record.time_s);
  record_motion(model, after, record);
  record_forces(model, after, control, record);
  if (model.scene.task.phases.empty()) return record;
  record.arm_m = model.scene.object.X_WO.linear().transpose() * arm_m(after.arm, record.time_s);
  const Vector3d& gravity = model.scene.gravity;
  if (!gravity.isZero(0.0)) {
    for (const FingerLoad& load : after.load) record.borne_N -= load.force_N.dot(gravity.normalized());
  }
  return record;
}

std::string interruption(double time_s) { return fmt::format("the run was interrupted at {:.3f} s", time_s); }

void RunSums::add(TickRecord& tick) {
  const int fingers = static_cast<int>(tick.contact.patch.size());
  if (slip_m_.size() != tick.contact.patch.size()) {
    slip_m_ = spin_rad_ = start_slip_m_ = start_spin_rad_ = turn_rad_ = PerFinger<double>(fingers);
    walk_m_ = PerFinger<Vector3d>(fingers, Vector3d::Zero());
  }
  for (int k = 0; k < fingers; ++k) {
    const PatchReport& patch = tick.contact.patch[k];
    slip_m_[k] += patch.slip_m;
    spin_rad_[k] += std::abs(patch.spin_rad);
    if (tick.is_measured()) {
      walk_m_[k] += tick.X_WO.linear().transpose() * patch.slip_W;
      turn_rad_[k] += patch.spin_rad;
    } else {
      start_slip_m_[k] = slip_m_[k];
      start_spin_rad_[k] = spin_rad_[k];
    }
  }
  ledger_.add(tick.contact.ledger);
  // All ticks of a frame have the report of its control tick.
  if (tick.contact.handed_over && tick.reflex.event != ReflexEvent::kNone) {
    last_reflex_ = {tick.reflex.event, tick.reflex.finger, tick.time_s};
  }
  stiffness_.add(tick.time_s, tick.stiffness);
  tick.slip_m = slip_m_;
  tick.spin_rad = spin_rad_;
  tick.start_slip_m = start_slip_m_;
  tick.start_spin_rad = start_spin_rad_;
  tick.walk_m = walk_m_;
  tick.turn_rad = turn_rad_;
  tick.ledger = ledger_;
  tick.last_reflex = last_reflex_;
}

TickRecord tick_record(const Model& model, const Tick& tick, RunSums& sums) {
  TickRecord record = tick_record(model, tick.after, tick.contact, tick.control);
  if (tick.controlled) record_control(tick.control, record);
  record.interpolate_s = tick.display_s;
  sums.add(record);
  return record;
}

namespace {

/// Writes column `now`, with room for more: a run may be longer than its scene.
template <typename Numbers>
void put(const Numbers& numbers, Eigen::Index now, Eigen::MatrixXd& all) {
  if (all.rows() == 0) return;
  if (now == all.cols()) all.conservativeResize(Eigen::NoChange, std::max<Eigen::Index>(16, 2 * now));
  all.col(now) = numbers;
}

}  // namespace

Recorder::Recorder(const Model& model)
    : model_(model),
      planned_(static_cast<std::int64_t>(std::ceil(model.scene.duration_s / model.scene.step_s - 1e-9))),
      monitor_(model) {}

void Recorder::make_room() {
  recording_.ticks.reserve(planned_);
  const auto muscles = std::ssize(model_.scene.hand.muscles);
  recording_.muscle_forces_N.resize(model_.scene.has_muscles() ? muscles : 0, planned_);
  recording_.muscles_asked_N.resize(model_.scene.muscles_act() ? muscles : 0, planned_);
}

bool Recorder::see_control(const ControlTick& tick) {
  monitor_.add(tick.time_s, tick.report, tick.muscle_forces_N);
  return !recording_.ticks.empty() || !monitor_.unsolved();
}

bool Recorder::see_tick(const Tick& tick) {
  if (recording_.ticks.empty()) make_room();
  const auto now = std::ssize(recording_.ticks);
  put(tick.after.pull_N, now, recording_.muscle_forces_N);
  put(tick.muscle_forces_N, now, recording_.muscles_asked_N);
  monitor_.add(recording_.ticks.emplace_back(tick_record(model_, tick, sums_)), tick.after.pull_N);
  return !monitor_.is_closed();
}

Recording Recorder::finish(const Snapshot& state, const ControlReport& control, double wall_s) {
  const auto ticks = std::ssize(recording_.ticks);
  recording_.stopped = ticks < planned_;
  recording_.wall_s = wall_s;
  if (ticks > 0 && !interrupted_) monitor_.end();
  recording_.verdict = monitor_.verdict();
  recording_.unsolved = monitor_.unsolved();
  if (ticks == 0) make_room();
  recording_.muscle_forces_N.conservativeResize(Eigen::NoChange, ticks);
  recording_.muscles_asked_N.conservativeResize(Eigen::NoChange, ticks);
  if (control.has_forces && ticks > 0) {
    HandPose pose;
    forward_kinematics(model_.scene.hand, state.q, pose);
    recording_.predicted_paper_law_error = predicted_paper_law_error(model_, pose, control.contacts, control.f_desired);
  }
  return std::move(recording_);
}

}  // namespace thenar
