#include "engine/contact_tick.h"

#include <algorithm>
#include <cmath>

#include "engine/control.h"
#include "engine/handover.h"
#include "engine/object_compliance.h"
#include "engine/stopwatch.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// The posture spring of a hold. Frozen torques alone let the grasp creep away within seconds.
constexpr double kHoldStiffness = 1.0;  // [N m/rad]

/// What moves the bodies beside contact.
struct Drive {
  JointVector torque;
  Vector6d wrench;
  Mobility mobility;
};

/// Displacements of a tick: joints [rad]; object's centre [m] and rotation vector [rad], world axes.
struct RigidMotion {
  JointVector dq;
  Vector6d dx;
};

RigidMotion viscous_motion(const Mobility& mobility, const JointVector& torque, const Vector6d& wrench) {
  RigidMotion motion;
  motion.dq = mobility.joint * torque;
  motion.dx.head<3>() = mobility.translation * wrench.head<3>();
  motion.dx.tail<3>() = mobility.rotation * wrench.tail<3>();
  return motion;
}

bool is_finite(const TickInput& input) {
  return input.wrench.allFinite() && (!input.X_WT || input.X_WT->matrix().allFinite());
}

/// Whether the frame is too old, or the fingertips have moved so far against the object since that its contacts mean
/// little.
bool must_hold(const Model& model, const Frame& frame, const State& state, const ContactWorkspace& work) {
  if (!std::isfinite(work.policy.hold_after_s)) return false;
  if (static_cast<double>(state.tick - frame.tick) * model.scene.step_s > work.policy.hold_after_s) return true;
  for (int k = 0; k < kFingers; ++k) {
    const Fingertip& tip = model.scene.hand.fingertips[k];
    const Vector3d now_O = state.X_WO.inverse() * (work.pose.distal(model.scene.hand, k) * tip.centre_m);
    const Vector3d then_O = frame.X_WO.inverse() * (frame.X_WF[k] * tip.centre_m);
    if ((now_O - then_O).norm() > kTrustPerRadius * tip.radius_m) return true;
  }
  return false;
}

/// Begins or ends a hold.
void set_hold(bool held, const Frame& frame, ContactWorkspace& work, State& state) {
  if (held) {
    work.q_held = state.q;
    work.torque_held_Nm = work.torque_Nm;
    work.resumed_Nm.setZero();
  } else {
    work.resumed_Nm = work.torque_Nm - frame.torque_Nm;
  }
  state.held = held;
}

Drive drive(const Model& model, const Frame& frame, const Vector6d& wrench, ContactWorkspace& work,
            const State& state) {
  const Scene& scene = model.scene;
  Drive drive{frame.torque_Nm + work.resumed_Nm, frame.wrench + wrench,
              mobility(scene, state.held ? kHoldStiffness : 0.0)};
  if (state.held) drive.torque = work.torque_held_Nm - kHoldStiffness * (state.q - work.q_held);
  work.resumed_Nm *= std::exp(-scene.step_s / kResume_s);
  work.torque_Nm = drive.torque;
  if (const auto& spring = scene.task.spring) {
    const double end_s = static_cast<double>(state.tick + 1) * scene.step_s;
    const Vector6d error = pose_error(state.X_WT.value_or(model.target(end_s)), state.X_WO);
    drive.wrench.head<3>() += spring->translation_N_per_m * error.head<3>();
    drive.wrench.tail<3>() += spring->rotation_Nm_per_rad * error.tail<3>();
  }
  return drive;
}

void free_gaps_and_slips(const Model& model, const Frame& frame, const State& state, const RigidMotion& free,
                         ContactWorkspace& work) {
  const ContactKinematics& now = work.kinematics;
  const double rho_object = model.soft_object() ? memory(*model.scene.object.compliance, model.scene.step_s) : 0.0;
  for (int k = 0; k < kFingers; ++k) {
    const double rho = model.deformable() ? memory(model.pulps[k].material, model.scene.step_s) : 0.0;
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      Vector3d delta = now.J_finger.middleRows<3>(3 * i) * free.dq.segment<kJointsPerFinger>(kJointsPerFinger * k) +
                       now.J_object.middleRows<3>(3 * i).leftCols<6>() * free.dx;
      delta -= (1.0 - rho) * (now.E_F[i].transpose() * displacement(state, frame.contacts[i]));
      if (model.soft_object()) delta -= (1.0 - rho_object) * now.u_object_m.col(i);
      delta[0] += now.gap_m[i] + work.offset_m[i];
      work.delta_free.segment<3>(3 * i) = delta;
    }
  }
}

/// The motion of the bodies by contact forces, as a solve in factors leaves it.
void find_contact_motion(const GroupedDelassus& W, const Eigen::VectorXd& f, GroupedWorkspace& motion) {
  motion.own_motion.setZero();
  motion.common_motion.setZero();
  for (Index k = 0; k < W.groups(); ++k) {
    for (Index r = 3 * W.begin[k]; r < 3 * W.begin[k + 1]; ++r) {
      motion.own_motion.col(k) += W.own_mobility * f[r] * W.J_own.row(r).transpose();
      motion.common_motion += f[r] * W.J_common.row(r).transpose();
    }
  }
  motion.common_motion.array() *= W.common_mobility.array();
}

SolveReport find_forces(const Model& model, const Frame& frame, const GroupedDelassus& W, ContactWorkspace& work) {
  const Index n = frame.size();
  const GaussSeidelSettings settings{model.scene.contact.tolerance, model.scene.contact.max_sweeps};
  const auto delta_free = work.delta_free.head(3 * n);
  const auto mu = work.mu.head(n);
  auto f = work.f.head(3 * n), delta = work.delta.head(3 * n);
  if (!work.dense) return solve_contacts(W, delta_free, mu, settings, work.solver, f, delta);
  auto dense = work.dense->W.topLeftCorner(3 * n, 3 * n);
  W.to_dense(dense);
  const double rho = memory(*model.scene.object.compliance, model.scene.step_s);
  dense += (1.0 - rho) * frame.object_compliance.topLeftCorner(3 * n, 3 * n);
  const SolveReport report = solve_contacts(dense, delta_free, mu, settings, work.dense->sweeps, f, delta);
  find_contact_motion(W, work.f, work.solver);
  return report;
}

FingerLoad finger_load(const Frame& frame, const ContactKinematics& now, int k, const Eigen::VectorXd& f) {
  FingerLoad load;
  for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
    if (f[3 * i] <= 0.0) continue;
    load.force_N += now.E_W[i] * f.segment<3>(3 * i);
    load.normal_N += f[3 * i];
    load.centre_m += f[3 * i] * now.c_W[i];
    load.normal += f[3 * i] * now.E_W[i].col(0);
  }
  if (load.normal_N > 0.0) {
    load.centre_m /= load.normal_N;
    load.normal.normalize();
  }
  return load;
}

void move(const RigidMotion& motion, State& state) {
  state.q += motion.dq;
  state.X_WO.translation() += motion.dx.head<3>();
  const Vector3d turn = motion.dx.tail<3>();
  const double angle = turn.norm();
  if (angle > 0.0) state.X_WO.linear() = Eigen::AngleAxisd(angle, turn / angle) * state.X_WO.linear();
}

/// How far the control points that the lists have no room for are in the object, at the state that the tick starts from.
void report_left_out(const Model& model, const Frame& frame, const ContactWorkspace& work, const State& state,
                     TickReport& report) {
  int finger = -1;
  Isometry3d X_FO;
  for (const FrameContact& point : frame.left_out) {
    if (point.finger != finger) {
      finger = point.finger;
      X_FO = work.pose.distal(model.scene.hand, finger).inverse() * state.X_WO;
    }
    const ContactGap gap =
        contact_gap(point, X_FO, displacement(state, point), object_displacement(model, state, point));
    report.left_out_m[finger] = std::max(report.left_out_m[finger], -gap.gap_m);
  }
  for (const double depth_m : report.left_out_m) report.penetration_m = std::max(report.penetration_m, depth_m);
}

void report_contacts(const Frame& frame, const ContactWorkspace& work, TickReport& report) {
  report.contacts = frame.size();
  double work_J = 0.0;  // of the contact forces on the bodies
  for (int k = 0; k < kFingers; ++k) {
    bool loaded = false;
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      report.penetration_m = std::max(report.penetration_m, work.offset_m[i] - work.delta[3 * i]);
      if (work.f[3 * i] <= 0.0) continue;
      const auto slip = work.delta.segment<2>(3 * i + 1);
      work_J += work.f[3 * i] * (work.delta[3 * i] - work.offset_m[i] - work.kinematics.gap_m[i]) +
                work.f.segment<2>(3 * i + 1).dot(slip);
      const double slip_m = slip.norm();
      report.slip_m[k] = loaded ? std::min(report.slip_m[k], slip_m) : slip_m;
      loaded = true;
      ++report.active;
    }
  }
  (work_J > 0.0 ? report.injected_J : report.dissipated_J) = std::abs(work_J);
}

/// Moves the bodies by their free and their contact motion, and takes stock of what the fingers do. False, and nothing
/// has moved, if that is not finite.
bool commit(const Frame& frame, const ContactWorkspace& work, RigidMotion motion, State& state) {
  motion.dq += work.solver.own_motion.reshaped();
  motion.dx += work.solver.common_motion.head<6>();
  if (!motion.dq.allFinite() || !motion.dx.allFinite()) return false;
  const Eigen::VectorXd& f = work.f;
  move(motion, state);
  for (int k = 0; k < kFingers; ++k) state.load[k] = finger_load(frame, work.kinematics, k, f);
  state.forces.clear();
  for (Index i = 0; i < frame.size(); ++i) {
    state.forces.push_back({frame.contacts[i].finger, frame.contacts[i].control_point, f.segment<3>(3 * i)});
  }
  return true;
}

}  // namespace

FramePolicy split_policy(const Scene& scene) {
  FramePolicy policy;
  policy.offset_decay_s = scene.control_period_s;
  if (scene.control) policy.hold_after_s = 3.0 * scene.control_period_s + scene.control_delay_s;
  return policy;
}

ContactWorkspace::ContactWorkspace(const Model& model, const FramePolicy& frame_policy)
    : policy(frame_policy),
      kinematics(model),
      offset_m(Eigen::VectorXd::Zero(model.max_contacts)),
      old_offset_m(Eigen::VectorXd::Zero(model.max_contacts)),
      delta_free(3 * model.max_contacts),
      delta(3 * model.max_contacts),
      f(3 * model.max_contacts),
      mu(Eigen::VectorXd::Constant(model.max_contacts, model.scene.contact.friction)),
      f_first(3 * model.max_contacts),
      solver(model.max_contacts, kFingers),
      torque_Nm(JointVector::Zero()),
      resumed_Nm(JointVector::Zero()),
      q_held(JointVector::Zero()),
      torque_held_Nm(JointVector::Zero()),
      loads(model) {
  contacts.reserve(model.max_contacts);
  if (model.soft_object()) dense.emplace(model.max_contacts);
  pose.segments.resize(model.scene.hand.segments.size());
}

TickReport contact_tick(const Model& model, const Frame& frame, ContactWorkspace& work, State& state,
                        const TickInput& input) noexcept {
  TickReport report;
  Stopwatch watch;
  const Scene& scene = model.scene;
  const Index n = frame.size();
  report.sequence = frame.sequence;
  report.frame_age = state.tick - frame.tick;
  report.handed_over = frame.sequence != work.sequence;
  const bool starts = work.sequence < 0;
  if (starts) state.held = false;  // This workspace has held nothing yet.
  report.input_refused = !is_finite(input);
  if (!report.input_refused) state.X_WT = input.X_WT;

  forward_kinematics(scene.hand, state.q, work.pose);
  // In the tick of a hand-over, too: frames that come at every step would add up their offsets.
  if (work.policy.offset_decay_s > 0.0) work.offset_m *= std::exp(-scene.step_s / work.policy.offset_decay_s);
  if (report.handed_over) {
    state.forces.reserve(model.max_contacts);  // A copied state has lost its spare room.
    if (model.soft_object()) state.object_loads.reserve(kLoadsPerContact * model.max_contacts);
    hand_over(model, frame, state, work);
  }
  report.held = must_hold(model, frame, state, work);
  if (report.held != state.held) set_hold(report.held, frame, work, state);
  const Vector6d extra = report.input_refused ? Vector6d(Vector6d::Zero()) : input.wrench;
  const Drive drive = thenar::drive(model, frame, extra, work, state);

  contact_kinematics(model, frame, work.pose, state, work.kinematics);
  // A scene that starts pressed has not been pushed out yet.
  if (!starts) report_left_out(model, frame, work, state, report);
  work.mobility = drive.mobility;
  const GroupedDelassus W = delassus_operator(model, frame, work.kinematics, work.mobility);
  report.assemble_s = watch.lap();

  const RigidMotion free = viscous_motion(drive.mobility, drive.torque, drive.wrench);
  free_gaps_and_slips(model, frame, state, free, work);
  work.f_first.head(3 * n) = work.f.head(3 * n);
  report.solve = find_forces(model, frame, W, work);
  report_contacts(frame, work, report);
  const bool moved = report.solve.status != SolveStatus::kNotFinite && commit(frame, work, free, state);
  if (!moved) report.solve = {SolveStatus::kNotFinite, report.solve.sweeps, std::numeric_limits<double>::infinity()};
  ++state.tick;
  report.solve_s = watch.lap();
  if (moved && model.deformable()) {
    for (int k = 0; k < kFingers; ++k) deform(model, frame, work.kinematics, k, work.f, work.loads, state);
    if (model.soft_object()) remember_loads(model, frame, work.kinematics, work.f, state);
    report.deform_s = watch.lap();
  }
  return report;
}

}  // namespace thenar
