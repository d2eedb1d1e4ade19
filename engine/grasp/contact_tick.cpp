// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/contact_tick.h"

#include <algorithm>
#include <cmath>

#include "engine/grasp/acting_muscles.h"
#include "engine/grasp/contact_gaps.h"
#include "engine/grasp/environment_tick.h"
#include "engine/grasp/handover.h"
#include "engine/grasp/object_compliance.h"
#include "engine/grasp/slides.h"
#include "engine/grasp/stopwatch.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// The posture spring of a hold. Frozen torques alone let the grasp creep away within seconds.
constexpr double kHoldStiffness = 1.0;  // [N m/rad]

bool has_stiff_muscles(const Scene& scene) { return scene.has_muscles() && scene.control->muscles->short_range; }

/// What moves the bodies beside contact.
struct Drive {
  JointVector torque;
  Vector6d wrench;
  Mobility mobility;
  PerFinger<JointMatrix> stiffness = {};  ///< Of muscles, which the mobility has, too; else of no finger.
};

/// Displacements of a tick: joints [rad]; object's origin [m] and rotation vector [rad], world axes.
struct RigidMotion {
  JointVector dq;
  Vector6d dx;
};

RigidMotion viscous_motion(const Hand& hand, const Mobility& mobility, const JointVector& torque,
                           const Vector6d& wrench) {
  RigidMotion motion;
  motion.dq = joint_motion(hand, mobility, torque);
  motion.dx.head<3>() = mobility.translation * wrench.head<3>();
  motion.dx.tail<3>() = mobility.rotation * wrench.tail<3>();
  return motion;
}

bool is_finite(const TickInput& input) {
  return input.wrench.allFinite() && (!input.X_WT || input.X_WT->matrix().allFinite());
}

/// Whether the frame is too old, or the fingertips have since moved too far against the object for its contacts.
bool must_hold(const Model& model, const Frame& frame, const State& state, const ContactMemory& memory,
               const ContactScratch& work) {
  if (!std::isfinite(memory.policy.hold_after_s)) return false;
  if (static_cast<double>(state.tick - frame.tick) * model.scene.step_s > memory.policy.hold_after_s) return true;
  for (int k = 0; k < model.fingers(); ++k) {
    const Fingertip& tip = model.scene.hand.fingertips[k];
    const Vector3d now_O = state.X_WO.inverse() * (work.pose.distal(model.scene.hand, k) * tip.centre_m);
    const Vector3d then_O = frame.X_WO.inverse() * (frame.X_WF[k] * tip.centre_m);
    if ((now_O - then_O).norm() > kTrustPerRadius * tip.radius_m) return true;
  }
  return false;
}

/// Begins or ends a hold.
void set_hold(bool held, const Frame& frame, ContactMemory& memory, State& state) {
  if (held) {
    memory.q_held = state.q;
    memory.torque_held_Nm = memory.torque_Nm;
    memory.resumed_Nm.setZero();
  } else {
    memory.resumed_Nm = memory.torque_Nm - frame.torque_Nm;
  }
  state.held = held;
}

Drive drive(const Model& model, const Frame& frame, const Vector6d& wrench, const State& state, ContactMemory& memory,
            ContactScratch& work) {
  const Scene& scene = model.scene;
  // Muscles that have stiffness hold a posture by themselves.
  const bool are_stiff = has_stiff_muscles(scene), held = state.held && !are_stiff;
  Drive drive{frame.torque_Nm + memory.resumed_Nm, frame.wrench + wrench, mobility(scene, held ? kHoldStiffness : 0.0),
              PerFinger<JointMatrix>(are_stiff ? model.fingers() : 0)};
  if (held) drive.torque = memory.torque_held_Nm - kHoldStiffness * (state.q - memory.q_held);
  if (scene.hand.slides) drive_slides(scene, static_cast<double>(state.tick) * scene.step_s, state.q, drive.torque);
  memory.resumed_Nm *= std::exp(-scene.step_s / kResume_s);
  memory.torque_Nm = drive.torque;
  if (scene.muscles_act()) let_muscles_act(model, frame, state, work.bellies, drive.torque, drive.stiffness);
  if (drive.stiffness.size() > 0) add_stiffness(scene, drive.stiffness, drive.mobility);
  // The points where weight and push act have turned with the object since the snapshot.
  const double asked_s = static_cast<double>(frame.tick) * scene.step_s;
  const double now_s = model.loads_vary() ? static_cast<double>(state.tick) * scene.step_s : asked_s;
  drive.wrench += model.external_wrench(now_s, state.X_WO) - model.external_wrench(asked_s, frame.X_WO);
  if (scene.task.arm) {
    drive.torque -= gravity_torques(scene.hand, work.pose, model.gravity(now_s) - model.gravity(asked_s));
  }
  if (const auto& spring = scene.task.spring) {
    const double end_s = static_cast<double>(state.tick + 1) * scene.step_s;
    const Vector6d error = pose_error(state.X_WT.value_or(model.target(end_s)), state.X_WO);
    drive.wrench.head<3>() += spring->translation_N_per_m * error.head<3>();
    drive.wrench.tail<3>() += spring->rotation_Nm_per_rad * error.tail<3>();
  }
  return drive;
}

void free_gaps_and_slips(const Model& model, const Frame& frame, const RigidMotion& free, const ContactMemory& memory,
                         ContactScratch& work) {
  const ContactKinematics& now = work.kinematics;
  const double rho_object =
      model.soft_object() ? retained_share(*model.scene.object.compliance, model.scene.step_s) : 0.0;
  for (int k = 0; k < model.fingers(); ++k) {
    const FingerVector dq = model.scene.hand.of_finger(k, free.dq);
    const Eigen::Vector4d dq_4 = dq.head<4>();
    const double rho = model.deformable() ? retained_share(model.pulps[k].material, model.scene.step_s) : 0.0;
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      const Vector3d back = (1.0 - rho) * (now.E_F[i].transpose() * now.points[i].u_F);
      // Row by row: vectors that are put together from sums would be written in parts and read whole.
      for (int r = 0; r < 3; ++r) {
        const Index row = 3 * i + r;
        double delta = now.J_finger.row(row).dot(dq_4) + now.J_object.row(row).head<6>().dot(free.dx) - back[r];
        if (dq.size() > 4) delta += now.J_fifth[row] * dq[4];
        if (model.soft_object()) delta -= (1.0 - rho_object) * now.u_object_m(r, i);
        if (r == 0) delta += now.gap_m[i] + now.gap_unit[i] * memory.offset_m[i];
        work.delta_free[row] = delta;
      }
    }
  }
}

SolveReport find_forces(const Model& model, const Frame& frame, const GroupedDelassus& W, ContactMemory& memory,
                        ContactScratch& work, const CommonGround* ground = nullptr) {
  // The residual of each tick moves bodies at rest a little, which at the tolerance injects more than 1 nW a contact.
  // Their forces change little, so that a few more sweeps reach a tenth of it; a moving grasp stops at the tolerance.
  constexpr double kShareOfFirst = 1e-2, kLeastShare = 0.1;
  const Index n = frame.size();
  const GaussSeidelSettings settings{.tolerance = model.scene.contact.tolerance,
                                     .max_sweeps = model.scene.contact.max_sweeps,
                                     .share_of_first = kShareOfFirst,
                                     .least_share = kLeastShare};
  const GroupedContactProblem factored{W, work.delta_free.head(3 * n), work.mu.head(n), ground};
  const ContactSolution solution{memory.f.head(3 * n), work.delta.head(3 * n)};
  return solve_contacts(factored, settings, memory.solver, solution);
}

/// Inlined in both callers, so that the products of a tick are contracted as they are there.
[[gnu::always_inline]] inline FingerLoad finger_load(const Frame& frame, const ContactKinematics& now, int k,
                                                     const Eigen::VectorXd& f) {
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

/// How far the control points that the lists have no room for are in the object, at the state that the tick starts
/// from.
void report_left_out(const Model& model, const Frame& frame, const ContactKinematics& kinematics, const State& state,
                     TickReport& report) {
  for_each_gap(model, frame.left_out, kinematics.X_FO, state, [&](Index i, double gap_m) {
    const FrameContact& point = frame.left_out[i];
    report.left_out_m[point.finger] = std::max(report.left_out_m[point.finger], -point.covered * gap_m);
  });
  for (const double depth_m : report.left_out_m) report.penetration_m = std::max(report.penetration_m, depth_m);
}

void report_contacts(const Frame& frame, const ContactMemory& memory, const ContactScratch& work, TickReport& report) {
  report.contacts = frame.size();
  for (Index i = 0; i < frame.size(); ++i) {
    const FrameContact& contact = frame.contacts[i];
    const double unit = work.kinematics.gap_unit[i];
    report.penetration_m =
        std::max(report.penetration_m, contact.covered * (memory.offset_m[i] - work.delta[3 * i] / unit));
    if (memory.f[3 * i] <= 0.0) continue;
    ++report.active;
    double work_J = memory.f[3 * i] * (work.delta[3 * i] - unit * memory.offset_m[i] - work.kinematics.gap_m[i]);
    if (contact.fades()) {
      // Its compliance changes with the bodies' motion, and what that takes or gives leans.
      report.ledger.deformation_J -= work_J;
      work_J = 0.0;
    }
    work_J += memory.f.segment<2>(3 * i + 1).dot(work.delta.segment<2>(3 * i + 1));
    (work_J > 0.0 ? report.ledger.injected_J : report.ledger.dissipated_J) += std::abs(work_J);
    report.injected_J[frame.contacts[i].finger] += std::max(0.0, work_J);
  }
}

/// Lets the forces go on changing as in the last two ticks if these changed them alike. Of a motion that is smooth this
/// leaves an error of second order in the step, where the last forces have one of first order. Forces at rigid
/// fingertips need not be unique: there, some that move nothing would go on for ever.
void foresee_forces(const Model& model, const Frame& frame, ContactMemory& memory) {
  const Index rows = 3 * frame.size();
  const auto change = memory.change_N.col(0).head(rows), before = memory.change_N.col(1).head(rows);
  if (!model.deformable() || !((change - before).squaredNorm() < change.squaredNorm())) return;
  for (Index row = 0; row < rows; row += 3) {
    if (memory.f[row] + change[row] > 0.0) memory.f.segment<3>(row) += change.segment<3>(row);
  }
}

/// The forces of contact and of the joints' stops, and how they and the drive move the bodies.
RigidMotion solve_motion(const Model& model, const Frame& frame, const Drive& drive, const State& state,
                         ContactMemory& memory, ContactScratch& work, TickReport& report) {
  constexpr int kMostSolves = 8;  // Bounds the time of a tick in which many joints meet their stops.
  constexpr int kMostLooks = 3;
  const Hand& hand = model.scene.hand;
  memory.stops.released.fill(false);
  RigidMotion motion;
  std::optional<CommonGround> ground = ground_of(model, drive.mobility, drive.wrench, work.environment);
  for (int solves = 1, looks = 1;; ++solves) {
    work.mobility = drive.mobility;
    stop_joints(hand, memory.stops, model.scene.step_s, work.mobility);
    set_shares(model, frame, work.mobility, work.kinematics);
    const GroupedDelassus W = delassus_operator(model, frame, work.kinematics, work.mobility);
    motion = viscous_motion(hand, drive.mobility, drive.torque, drive.wrench);
    move_to_stops(hand, memory.stops, state.q, model.scene.step_s, work.mobility, drive.torque, motion.dq);
    if (hand.slides) {
      follow_paths(model.scene, static_cast<double>(state.tick + 1) * model.scene.step_s, state.q, motion.dq);
    }
    free_gaps_and_slips(model, frame, motion, memory, work);
    work.f_first.head(3 * frame.size()) = memory.f.head(3 * frame.size());
    report.solve = find_forces(model, frame, W, memory, work, ground ? &*ground : nullptr);
    add_joint_motion(hand, work.mobility, memory.solver, motion.dq);
    motion.dx += memory.solver.common_motion.head<6>();
    report.stop_Nm = stop_torques(hand, memory.stops, frame, work.kinematics, model.scene.step_s, drive.mobility,
                                  drive.torque, motion.dq, memory.f);
    if (!change_stops(hand, state.q, motion.dq, report.stop_Nm, memory.stops)) {
      if (!ground || looks == kMostLooks || solves == kMostSolves ||
          !look_again(model, drive.mobility, drive.wrench, state, motion.dx, memory, work)) {
        return motion;
      }
      ++looks;
      ground = ground_of(model, drive.mobility, drive.wrench, work.environment);
    }
    if (solves == kMostSolves) break;
  }
  end_at_stops(hand, state.q, motion.dq);
  return motion;
}

/// Solves a tick's motion from the forces that it foresees, and remembers how they changed.
RigidMotion find_motion(const Model& model, const Frame& frame, const Drive& drive, const State& state,
                        ContactMemory& memory, ContactScratch& work, TickReport& report) {
  const Index rows = 3 * frame.size();
  work.f_then.head(rows) = memory.f.head(rows);
  foresee_forces(model, frame, memory);
  RigidMotion motion = solve_motion(model, frame, drive, state, memory, work, report);
  memory.change_N.col(1).head(rows) = memory.change_N.col(0).head(rows);
  memory.change_N.col(0).head(rows) = memory.f.head(rows) - work.f_then.head(rows);
  if (report.solve.status == SolveStatus::kNotFinite) memory.change_N.setZero();
  return motion;
}

/// The bodies' part of the ledger: the drive is taken at the end of the step, as the springs are.
void book_motion(const Scene& scene, const Drive& drive, const State& state, const RigidMotion& motion,
                 TickReport& report) {
  Ledger& ledger = report.ledger;
  const Spring spring = scene.task.spring.value_or(Spring{});
  const double joints = motion.dq.squaredNorm(), way = motion.dx.head<3>().squaredNorm(),
               turn = motion.dx.tail<3>().squaredNorm();
  ledger.drive_J = drive.torque.dot(motion.dq) + drive.wrench.dot(motion.dx) -
                   (state.held && !has_stiff_muscles(scene) ? kHoldStiffness : 0.0) * joints -
                   spring.translation_N_per_m * way - spring.rotation_Nm_per_rad * turn;
  for (std::size_t k = 0; k < drive.stiffness.size(); ++k) {
    const auto dq = motion.dq.segment(scene.hand.fingertips[k].first_joint, scene.hand.fingertips[k].joints);
    ledger.drive_J -= dq.dot(drive.stiffness[k].lazyProduct(dq).eval());
  }
  double joints_J_s = scene.joint_viscosity * joints;
  if (drive.mobility.root.size() > 0) {
    joints_J_s = 0.0;
    for (int k = 0; k < scene.hand.fingers(); ++k) {
      const Fingertip& tip = scene.hand.fingertips[k];
      joints_J_s += scene.viscosity(k) * motion.dq.segment(tip.first_joint, tip.joints).squaredNorm();
      for (int j = tip.first_joint; tip.followers > 0 && j < tip.first_joint + tip.joints; ++j) {
        joints_J_s += scene.viscosity(k) * (scene.hand.joints[j].drag - 1.0) * motion.dq[j] * motion.dq[j];
      }
    }
  }
  ledger.viscous_J =
      (joints_J_s + scene.object.translation_damping * way + scene.object.rotation_damping * turn) / scene.step_s;
  for (Index j = 0; j < motion.dq.size(); ++j) {
    const double work_J = report.stop_Nm[j] * motion.dq[j];
    (work_J > 0.0 ? ledger.injected_J : ledger.dissipated_J) += std::abs(work_J);
  }
}

/// Moves the bodies by their free and their contact motion, and takes stock of what the fingers do. False, and nothing
/// has moved, if that is not finite.
bool commit(const Model& model, const Frame& frame, const ContactKinematics& kinematics, const Eigen::VectorXd& f,
            const RigidMotion& motion, State& state) {
  if (!motion.dq.allFinite() || !motion.dx.allFinite()) return false;
  state.q += motion.dq;
  state.X_WO = moved(state.X_WO, motion.dx);
  for (int k = 0; k < model.fingers(); ++k) state.load[k] = finger_load(frame, kinematics, k, f);
  state.forces.clear();
  for (Index i = 0; i < frame.size(); ++i) {
    const FrameContact& contact = frame.contacts[i];
    state.forces.push_back(
        {contact.finger, contact.control_point, f.segment<3>(3 * i), 0.0, covered_share(model, contact)});
  }
  if (!state.contact_forces.empty()) {
    const auto rest = std::ranges::copy(state.forces, state.contact_forces.begin()).out;
    std::fill(rest, state.contact_forces.end(), ContactForce{kMaxFingers, 0, Vector3d::Zero()});
  }
  return true;
}

/// Says where the bodies are at the start of a tick.
void place_bodies(const Model& model, const State& state, ContactScratch& work) {
  if (state.q != work.pose.q) forward_kinematics(model.scene.hand, state.q, work.pose);
  place_bodies(model, work.pose, state, work.kinematics);
}

/// Lets pulps that lie in the object give way, bodies at rest: gaps + C f closed. A soft object, too. At the start of a
/// run pulps that are sheared stick to it. Gaps have been found, and are found again.
void press_in(const Model& model, const Frame& frame, ContactMemory& memory, ContactScratch& work, State& state) {
  const bool is_undeformed = state.forces.empty() && state.object_loads.empty() &&
                             std::ranges::all_of(state.u_m, [](const auto& u) { return u.isZero(0.0); });
  if (!model.deformable() || !is_undeformed) return;
  find_jacobians(model, frame, work.pose, state, work.kinematics);
  const Index n = frame.size();
  const auto gaps_m = work.kinematics.gap_m.head(n);
  if (n == 0 || gaps_m.minCoeff() >= 0.0) return;
  // One tick of bodies that nothing moves. To have all of C f and C_o f, forces are taken by the shares that
  // deformation gains of them in a tick.
  const double object_share =
      model.soft_object() ? 1.0 - retained_share(*model.scene.object.compliance, model.scene.step_s) : 1.0;
  GroupedDelassus W = delassus_operator(model, frame, work.kinematics, {0.0, 0.0, 0.0});
  W.compliance_scale = object_share;
  W.group_scale = {};
  W.list = W.edition = -1;  // No tick's W is like it.
  work.delta_free.head(3 * n).setZero();
  for (Index i = 0; i < n; ++i) work.delta_free[3 * i] = gaps_m[i];
  for (int k = 0; k < model.fingers() && model.start && state.tick == 0; ++k) {
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      const Vector3d sheared_m = work.kinematics.E_W[i].transpose() * (*model.start)[k].sheared_m;
      work.delta_free.segment<2>(3 * i + 1) = -sheared_m.tail<2>();
    }
  }
  if (find_forces(model, frame, W, memory, work).status == SolveStatus::kNotFinite) return;
  if (model.soft_object()) remember_loads(model, frame, work.kinematics.object_tensors, memory.f, state);
  for (int k = 0; k < model.fingers(); ++k) {
    const double share = 1.0 - retained_share(model.pulps[k].material, model.scene.step_s);
    auto f_k = memory.f.segment(3 * frame.begin[k], 3 * (frame.begin[k + 1] - frame.begin[k]));
    f_k *= object_share / share;
    deform(model, frame, work.kinematics, k, memory.f, memory.solver.surface_motion, work.loads, state);
    f_k *= share;
  }
  find_displacements(model, frame, work.kinematics, work.pose, state, memory.f, work.patches);
  Ledger start;
  book_deformation(model, frame, memory, work, true, state, start);
  find_gaps(model, frame, state, work.kinematics);
}

/// Once the bodies have moved: deforms pulps and a soft object, finds where the patches have gone, books the energy.
void deform_bodies(const Model& model, const Frame& frame, ContactMemory& memory, ContactScratch& work, State& state,
                   Ledger& ledger) {
  if (model.deformable()) {
    for (int k = 0; k < model.fingers(); ++k)
      deform(model, frame, work.kinematics, k, memory.f, memory.solver.surface_motion, work.loads, state);
    if (model.soft_object()) remember_loads(model, frame, work.kinematics.object_tensors, memory.f, state);
  }
  if (state.q != work.pose.q) forward_kinematics(model.scene.hand, state.q, work.pose);
  find_displacements(model, frame, work.kinematics, work.pose, state, memory.f, work.patches);
  if (model.deformable()) book_deformation(model, frame, memory, work, false, state, ledger);
}

/// Reports slip and load of the fingers' patches, and has the fingertips feel them.
void report_patches(const Model& model, const Frame& frame, double mu, ContactMemory& memory, ContactScratch& work,
                    State& state, TickReport& report) {
  for (int k = 0; k < model.fingers(); ++k) {
    if (state.load[k].normal_N > 0.0) report.small[k] = frame.small[k];
    report.patch[k] = patch_report(work.patches.of_finger(k), state.load[k], mu, model.scene.step_s);
  }
  for (int k = 0; k < std::ssize(state.touch); ++k) {
    state.touch[k] = felt_touch(model, frame, work.kinematics, work.patches.of_finger(k), state.load[k],
                                report.patch[k], mu, memory.touch_noise);
  }
}

}  // namespace

PerFinger<FingerLoad> first_loads(const Model& model, const Frame& frame) {
  ContactMemory memory(model);
  ContactScratch work(model);
  State state(model);
  place_bodies(model, state, work);
  hand_over(model, frame, state, memory, work);
  press_in(model, frame, memory, work, state);
  PerFinger<FingerLoad> loads(model.fingers());
  for (int k = 0; k < model.fingers(); ++k) loads[k] = finger_load(frame, work.kinematics, k, memory.f);
  return loads;
}

TickReport contact_tick(const Model& model, const Frame& frame, ContactMemory& memory, ContactScratch& work,
                        State& state, const TickInput& input) noexcept {
  TickReport report(model.scene.hand);
  Stopwatch watch;
  const Scene& scene = model.scene;
  report.sequence = frame.sequence;
  report.frame_age = state.tick - frame.tick;
  const double mu = model.friction(static_cast<double>(state.tick) * scene.step_s);
  report.handed_over = frame.sequence != memory.sequence;
  const bool starts = memory.sequence < 0;
  if (starts) state.held = false;  // This memory has held nothing yet.
  report.input_refused = !is_finite(input);
  if (!report.input_refused) state.X_WT = input.X_WT;

  place_bodies(model, state, work);
  // In the tick of a hand-over, too: frames that come at every step would add up their offsets.
  if (memory.policy.offset_decay_s > 0.0) memory.offset_m *= std::exp(-scene.step_s / memory.policy.offset_decay_s);
  if (report.handed_over) {
    reserve(model, work.environment.most(), state, memory);
    report.ledger.dropped_J = hand_over(model, frame, state, memory, work);
    if (starts) press_in(model, frame, memory, work, state);
  } else {
    find_gaps(model, frame, state, work.kinematics);
  }
  follow(frame.arm, static_cast<double>(state.tick) * scene.step_s, state.arm);
  if (scene.muscles_act()) activate(model, frame, state);
  report.held = must_hold(model, frame, state, memory, work);
  if (report.held != state.held) set_hold(report.held, frame, memory, state);
  const Vector6d extra = report.input_refused ? Vector6d(Vector6d::Zero()) : input.wrench;
  const Drive drive = thenar::drive(model, frame, extra, state, memory, work);

  if (!scene.task.friction.empty()) work.mu.setConstant(mu);
  find_jacobians(model, frame, work.pose, state, work.kinematics);
  // A scene that starts pressed has not been pushed out yet.
  if (!starts) report_left_out(model, frame, work.kinematics, state, report);
  report.assemble_s = watch.lap();

  if (scene.environment) look_around(model, drive.mobility, drive.wrench, state, work.environment);
  const RigidMotion motion = find_motion(model, frame, drive, state, memory, work, report);
  report_contacts(frame, memory, work, report);
  const bool moved =
      report.solve.status != SolveStatus::kNotFinite && commit(model, frame, work.kinematics, memory.f, motion, state);
  ++state.tick;
  if (moved && scene.has_muscles()) report.yielded = take_pulls(model, frame, work.bellies, motion.dq, state);
  if (moved && scene.environment) keep_environment(memory, work, state, report.environment);
  report.solve_s = watch.lap();
  if (!moved) {
    work.patches.clear();
    report.solve = {SolveStatus::kNotFinite, report.solve.sweeps, std::numeric_limits<double>::infinity()};
    report.ledger = {};
    return report;
  }
  book_motion(scene, drive, state, motion, report);
  if (scene.hand.slides) book_slides(scene, frame, work.kinematics, memory.f, motion.dq, report.ledger);
  if (scene.environment) book_environment(*scene.environment, memory, work, report.ledger);
  deform_bodies(model, frame, memory, work, state, report.ledger);
  report_patches(model, frame, mu, memory, work, state, report);
  (model.deformable() ? report.deform_s : report.solve_s) += watch.lap();
  return report;
}

}  // namespace thenar
