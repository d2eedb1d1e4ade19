#include "engine/contact_tick.h"

#include <algorithm>
#include <tuple>

#include "engine/stopwatch.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Displacements of a tick: joints [rad]; object's centre [m] and rotation vector [rad], world axes.
struct RigidMotion {
  JointVector dq;
  Vector6d dx;
};

/// h B^-1 times generalised forces.
RigidMotion viscous_motion(const Scene& scene, const JointVector& torque, const Vector6d& wrench) {
  RigidMotion motion;
  motion.dq = scene.step_s / scene.joint_viscosity * torque;
  motion.dx.head<3>() = scene.step_s / scene.object.translation_damping * wrench.head<3>();
  motion.dx.tail<3>() = scene.step_s / scene.object.rotation_damping * wrench.tail<3>();
  return motion;
}

/// Signed gap of a contact at the state: the finger point against the plane fixed in the object.
double rest_gap(const FrameContact& contact, const Isometry3d& X_WF, const Isometry3d& X_WO) {
  return (X_WO.linear() * contact.n_O).dot(X_WO * contact.s_O - X_WF * contact.p_F);
}

void free_gaps_and_slips(const Model& model, const Frame& frame, const State& state, const RigidMotion& free,
                         ContactWorkspace& work) {
  for (int k = 0; k < kFingers; ++k) {
    const Isometry3d& X_WF = work.pose.distal(model.scene.hand, k);
    const double rho = model.deformable() ? memory(model.pulps[k].material, model.scene.step_s) : 0.0;
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      const FrameContact& contact = frame.contacts[i];
      Vector3d delta = frame.J_finger.middleRows<3>(3 * i) * free.dq.segment<kJointsPerFinger>(kJointsPerFinger * k) +
                       frame.J_object.middleRows<3>(3 * i) * free.dx;
      delta[0] += rest_gap(contact, X_WF, state.X_WO);
      if (model.deformable()) {
        const Vector3d u_C = contact.E_F.transpose() * state.u_m[k].row(contact.control_point).transpose();
        delta[0] += rho * u_C[0];
        delta.tail<2>() += (rho - 1.0) * u_C.tail<2>();
      }
      work.delta_free.segment<3>(3 * i) = delta;
    }
  }
}

/// u = rho u + (1 - rho) C f of finger k, at all its control points.
void deform(const Model& model, const Frame& frame, int k, const Eigen::VectorXd& f, ContactWorkspace& work,
            State& state) {
  const Pulp& pulp = model.pulps[k];
  const double rho = memory(pulp.material, model.scene.step_s);
  auto& sum = work.kernel_sum;  // of k_ij T_j f_j over the contacts j
  sum.setZero();
  for (Index j = frame.begin[k]; j < frame.begin[k + 1]; ++j) {
    if (f[3 * j] <= 0.0) continue;
    const Matrix3d& E_F = frame.contacts[j].E_F;
    const Vector3d w = pulp.tensor(E_F.col(0)) * (E_F * f.segment<3>(3 * j));
    sum.noalias() += pulp.kernel.col(frame.contacts[j].control_point) * w.transpose();
  }
  auto& u = state.u_m[k];
  const auto& N = pulp.control_normals;
  const double a = pulp.tangential;
  // T_i of the rest normal everywhere, then of the contact's own normal at the contacts, as in W.
  u = rho * u +
      (1.0 - rho) * (a * sum + (1.0 - a) * ((N.array() * sum.array()).rowwise().sum().matrix().asDiagonal() * N));
  for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
    const Index c = frame.contacts[i].control_point;
    const Matrix3d change = pulp.tensor(frame.contacts[i].E_F.col(0)) - pulp.tensor(N.row(c).transpose());
    u.row(c) += (1.0 - rho) * (sum.row(c) * change);
  }
}

FingerLoad finger_load(const Frame& frame, int k, const Eigen::VectorXd& f, const Isometry3d& X_WO) {
  FingerLoad load;
  for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
    const FrameContact& contact = frame.contacts[i];
    load.force_N += contact.E_W * f.segment<3>(3 * i);
    load.normal_N += f[3 * i];
    load.centre_m += f[3 * i] * (X_WO * contact.s_O);
    load.normal += f[3 * i] * (X_WO.linear() * contact.n_O);
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

void report_contacts(const Frame& frame, const ContactWorkspace& work, TickReport& report) {
  report.contacts = frame.size();
  for (int k = 0; k < kFingers; ++k) {
    bool loaded = false;
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      report.penetration_m = std::max(report.penetration_m, -work.delta[3 * i]);
      if (work.f[3 * i] <= 0.0) continue;
      const double slip_m = work.delta.segment<2>(3 * i + 1).norm();
      report.slip_m[k] = loaded ? std::min(report.slip_m[k], slip_m) : slip_m;
      loaded = true;
      ++report.active;
    }
  }
}

/// Moves the bodies by their free and their contact motion, and takes stock of what the fingers do.
void commit(const Model& model, const Frame& frame, const Eigen::VectorXd& f, State& state) {
  const Index rows = 3 * frame.size();
  const Vector6d wrench = frame.wrench + frame.J_object.topRows(rows).transpose() * f.head(rows);
  JointVector torque = frame.torque_Nm;
  for (int k = 0; k < kFingers; ++k) {
    const Index first = 3 * frame.begin[k], count = 3 * frame.begin[k + 1] - first;
    torque.segment<kJointsPerFinger>(kJointsPerFinger * k) +=
        frame.J_finger.middleRows(first, count).transpose() * f.segment(first, count);
  }
  move(viscous_motion(model.scene, torque, wrench), state);
  for (int k = 0; k < kFingers; ++k) state.load[k] = finger_load(frame, k, f, state.X_WO);
  state.forces.clear();
  for (Index i = 0; i < frame.size(); ++i) {
    state.forces.push_back({frame.contacts[i].finger, frame.contacts[i].control_point, f.segment<3>(3 * i)});
  }
  ++state.tick;
}

}  // namespace

FramePolicy split_policy(const Scene&) { return {}; }

void carry_forces(const Frame& frame, const std::vector<ContactForce>& forces, Eigen::VectorXd& f) {
  auto old = forces.begin();
  for (Index i = 0; i < frame.size(); ++i) {
    const FrameContact& contact = frame.contacts[i];
    const auto id = std::tie(contact.finger, contact.control_point);
    while (old != forces.end() && std::tie(old->finger, old->control_point) < id) ++old;
    const bool known = old != forces.end() && std::tie(old->finger, old->control_point) == id;
    f.segment<3>(3 * i) = known ? old->f_C : Vector3d::Zero();
  }
}

ContactWorkspace::ContactWorkspace(const Model& model, const FramePolicy&)
    : delta_free(3 * model.max_contacts),
      delta(3 * model.max_contacts),
      f(3 * model.max_contacts),
      mu(Eigen::VectorXd::Constant(model.max_contacts, model.scene.contact.friction)),
      W_(9 * model.max_contacts * model.max_contacts) {
  if (model.deformable()) kernel_sum.resize(model.pulps.front().controls(), 3);
  pose.segments.resize(model.scene.hand.segments.size());
}

TickReport contact_tick(const Model& model, const Frame& frame, ContactWorkspace& work, State& state,
                        const TickInput& input) noexcept {
  TickReport report;
  state.X_WT = input.X_WT;
  report.sequence = frame.sequence;
  report.frame_age = state.tick - frame.tick;
  Stopwatch watch;
  const Index n = frame.size();
  auto W = work.W(n);
  state.forces.reserve(model.max_contacts);  // A copied state has lost its spare room.
  if (frame.sequence != work.sequence) {
    assemble_delassus(model, frame, W);
    carry_forces(frame, state.forces, work.f);
    work.sequence = frame.sequence;
    report.handed_over = true;
    report.assemble_s = watch.lap();
  }

  const Scene& scene = model.scene;
  forward_kinematics(scene.hand, state.q, work.pose);
  const RigidMotion free = viscous_motion(scene, frame.torque_Nm, frame.wrench);
  free_gaps_and_slips(model, frame, state, free, work);
  report.solve =
      solve_contacts(W, work.delta_free.head(3 * n), work.mu.head(n),
                     {scene.contact.tolerance, scene.contact.max_sweeps}, work.f.head(3 * n), work.delta.head(3 * n));
  report_contacts(frame, work, report);
  commit(model, frame, work.f, state);
  report.solve_s = watch.lap();
  if (model.deformable()) {
    for (int k = 0; k < kFingers; ++k) deform(model, frame, k, work.f, work, state);
    report.deform_s = watch.lap();
  }
  return report;
}

}  // namespace thenar
