// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "engine/loops/archive.h"
#include "engine/loops/run.h"

/// The state of a run as bytes: the members of each of its structs, named once. A struct with a new member does not
/// compile here until it is named, too, except where only some are named, by `x.member`.
namespace thenar {

/// Returns a fingerprint of the data in which a state and the model that continues from it must agree: the hand, the
/// object's and the pulps' points, the steps, the scene's parts, and lockstep.
[[nodiscard]] std::uint64_t state_fingerprint(const Model& model, bool is_lockstep);

/// Puts a head before the members of a state: its kind, the version of its format, the fingerprint, and a checksum.
[[nodiscard]] std::string sealed_state(std::uint64_t fingerprint, const std::string& members);
/// Returns the members of a state. Throws std::invalid_argument if the bytes are no state, of another format or
/// fingerprint, or incomplete.
[[nodiscard]] std::string_view opened_state(std::uint64_t fingerprint, std::string_view bytes);

/// Returns the state of a run between two ticks, without a caller's own control.
[[nodiscard]] std::string state_of(const GraspRun& run);
/// Sets the state of a run, which then continues with the same bits as a copy of the original. It keeps its own
/// control. Throws std::invalid_argument as opened_state() does, leaving the run unchanged.
void set_state(std::string_view bytes, GraspRun& run);

// --- members ---------------------------------------------------------------------------------------------------------

template <typename Archive>
void members(Archive& a, FingerLoad& x) {
  auto& [force_N, normal_N, centre_m, normal] = x;
  a(force_N, normal_N, centre_m, normal);
}

template <typename Archive>
void members(Archive& a, ContactForce& x) {
  auto& [finger, control_point, f_C, held_J, share] = x;
  a(finger, control_point, f_C, held_J, share);
}

template <typename Archive>
void members(Archive& a, ObjectLoad& x) {
  auto& [finger, control_point, x_O, area_m2, w_O] = x;
  a(finger, control_point, x_O, area_m2, w_O);
}

template <typename Archive>
void members(Archive& a, EnvironmentForce& x) {
  auto& [body, place, p_E, n_E, f_E] = x;
  a(body, place, p_E, n_E, f_E);
}

template <typename Archive>
void members(Archive& a, Touch& x) {
  auto& [stick, friction, slip_m_per_s, moment_Nm, normal_N, tangential_N] = x;
  a(stick, friction, slip_m_per_s, moment_Nm, normal_N, tangential_N);
}

template <typename Archive>
void members(Archive& a, ArmWay& x) {
  auto& [order, from_m, by_m, begin_s, over_s] = x;
  a(order, from_m, by_m, begin_s, over_s);
}

template <typename Archive>
void members(Archive& a, ArmOrder& x) {
  auto& [number, by_m, over_s] = x;
  a(number, by_m, over_s);
}

template <typename Archive>
void members(Archive& a, Snapshot& x) {
  auto& [tick, q, X_WO, load, muscle_N, pull_N, touch, contact_forces, arm, X_WT, held] = x;
  a(tick, q, X_WO, load, muscle_N, pull_N, touch, contact_forces, arm, X_WT, held);
}

template <typename Archive>
void members(Archive& a, State& x) {
  a(static_cast<Snapshot&>(x), x.u_m, x.forces, x.environment_forces, x.object_loads, x.pulp_energy_J,
    x.object_energy_J);
}

template <typename Archive>
void members(Archive& a, FrameContact& x) {
  auto& [finger, control_point, p_F, s_O, n_O, t_O, curvature_per_m, ring_curvature_per_m, area_m2, E_F, share, covered,
         lean_O, lean_m_per_N, press] = x;
  a(finger, control_point, p_F, s_O, n_O, t_O, curvature_per_m, ring_curvature_per_m, area_m2, E_F, share, covered,
    lean_O, lean_m_per_N, press);
}

template <typename Archive>
void members(Archive& a, SmallPatch& x) {
  auto& [narrow, overhang] = x;
  a(narrow, overhang);
}

template <typename Archive>
void members(Archive& a, SurfaceCompliance& x) {
  auto& [p_m, k, of_a, b, normal_rows, cross_rows, bent_rows] = x;
  a(p_m, k, of_a, b, normal_rows, cross_rows, bent_rows);
}

template <typename Archive>
void members(Archive& a, Belly& x) {
  auto& [muscle, finger, share, arms_m, slopes_m] = x;
  a(muscle, finger, share, arms_m, slopes_m);
}

template <typename Archive>
void members(Archive& a, Frame& x) {
  auto& [sequence, tick, X_WO, X_WF, contacts, begin, left_out, small, compliance, list, compliance_edition, softness,
         object_kernel, torque_Nm, muscle_N, bellies, q, q_rest, turning, wrench, arm] = x;
  a(sequence, tick, X_WO, X_WF, contacts, begin, left_out, small, compliance, list, compliance_edition, softness,
    object_kernel, torque_Nm, muscle_N, bellies, q, q_rest, turning, wrench, arm);
}

template <typename Archive>
void members(Archive& a, SentFrame& x) {
  auto& [due_s, frame] = x;
  a(due_s, frame);
}

template <typename Archive>
void members(Archive& a, FramePolicy& x) {
  auto& [offset_decay_s, hold_after_s] = x;
  a(offset_decay_s, hold_after_s);
}

template <typename Archive>
void members(Archive& a, JointStops& x) {
  auto& [side, released, stopped] = x;
  a(side, released, stopped);
}

template <typename Archive>
void members(Archive& a, TouchNoise& x) {
  auto& [share, random, normal] = x;
  a(share, random, normal);
}

template <typename Archive>
void members(Archive& a, LocalStep& x) {
  auto& [per_nn, t1n, t2n, per_tt, rho] = x;
  a(per_nn, t1n, t2n, per_tt, rho);
}

/// Visits the members that a solve inherits from the one before; it recomputes the rest.
template <typename Archive>
void members(Archive& a, GroupedWorkspace& x) {
  a(x.list, x.edition, x.compliance_scale, x.J_then, x.J_then_most, x.sweeps.J, x.sweeps.local, x.sweeps.blocks,
    x.sweeps.d_change, x.sweeps.d_moved, x.sweeps.d_f, x.sweeps.gram, x.sweeps.differences, x.ground.x,
    x.ground.inverse_slope, x.ground.has_slope);
}

template <typename Archive>
void members(Archive& a, ContactMemory& x) {
  auto& [policy, sequence, contacts, offset_m, f, change_N, stops, torque_Nm, resumed_Nm, q_held, torque_held_Nm,
         touch_noise, solver] = x;
  a(policy, sequence, contacts, offset_m, f, change_N, stops, torque_Nm, resumed_Nm, q_held, torque_held_Nm,
    touch_noise, solver);
}

template <typename Archive>
void members(Archive& a, PidGains& x) {
  auto& [p, i, d] = x;
  a(p, i, d);
}

template <typename Archive>
void members(Archive& a, Sensed& x) {
  auto& [snapshot, desired_N] = x;
  a(snapshot, desired_N);
}

template <typename Archive>
void members(Archive& a, PhaseLack& x) {
  auto& [fault, value, bound, finger] = x;
  a(fault, value, bound, finger);
}

template <typename Archive>
void members(Archive& a, TaskReport& x) {
  auto& [phase, since_s, holds, grasps, poses, integrates, speed_m_per_s, has_touched, touch_N, X_WT, weight_share,
         squeeze_N, lack, has_failed, at_s, arm_way_m, object_way_m] = x;
  a(phase, since_s, holds, grasps, poses, integrates, speed_m_per_s, has_touched, touch_N, X_WT, weight_share,
    squeeze_N, lack, has_failed, at_s, arm_way_m, object_way_m);
}

template <typename Archive>
void members(Archive& a, StiffOptimum& x) {
  auto& [forces, l, Z, Y] = x;
  a(forces, l, Z, Y);
}

template <typename Archive>
void members(Archive& a, StiffWarmStart& x) {
  auto& [is_set, variables, joints, fingers, at, way, bend, order, basis] = x;
  a(is_set, variables, joints, fingers, order);
  if (is_set) a(at, way, bend, basis);
}

template <typename Archive>
void members(Archive& a, KnownSample& x) {
  auto& [at_m, free_m, sample] = x;
  a(at_m, free_m, sample);
}

template <typename Archive>
void members(Archive& a, FindingMemory& x) {
  auto& [known, wakes_m, travelled_m, X_SB, band_m, reach_m, centre_m, radius_m, wider_m, widest_m] = x;
  a(known, wakes_m, travelled_m, X_SB, band_m, reach_m, centre_m, radius_m, wider_m, widest_m);
}

template <typename Archive>
void members(Archive& a, HeldContact& x) {
  auto& [contact, p_O, x_O, gap_m, deformed_gap_m, free_m, sample, face, is_smooth, is_round] = x;
  a(contact, p_O, x_O, gap_m, deformed_gap_m, free_m, sample, face, is_smooth, is_round);
}

/// Visits the members that a search inherits from the one before.
template <typename Archive>
void members(Archive& a, ContactSearch& x) {
  a(x.memory, x.known_deformed, x.held, x.known_before, x.known_ball, x.X_OF_then, x.tick_then, x.small.known);
}

/// Visits the members, without those that each period recomputes: bellies, moment arms, the hand's pose.
template <typename Archive>
void members(Archive& a, Controller& x) {
  a(x.sequence, x.last_tick, x.period_s, x.acting_share, x.pid, x.pid_phase, x.pid_integrates, x.borne, x.filter,
    x.f_desired, x.f_muscle, x.q_rest, x.afference, x.reflex, x.task, x.q_free, x.looks, x.stiffness, x.search,
    x.compliance);
}

template <typename Archive>
void members(Archive& a, GraspContact& x) {
  auto& [point_m, axes] = x;
  a(point_m, axes);
}

template <typename Archive>
void members(Archive& a, ContactGrip& x) {
  auto& [friction, internal_force_N] = x;
  a(friction, internal_force_N);
}

template <typename Archive>
void members(Archive& a, MuscleLack& x) {
  auto& [muscle, needed_N] = x;
  a(muscle, needed_N);
}

template <typename Archive>
void members(Archive& a, StiffnessReport& x) {
  auto& [is_chosen, share, is_infeasible, axis_O, rotates, lacking, at_limit, K_O, squeeze_N, iterations, residual,
         is_unanswered] = x;
  a(is_chosen, share, is_infeasible, axis_O, rotates, lacking, at_limit, K_O, squeeze_N, iterations, residual,
    is_unanswered);
}

template <typename Archive>
void members(Archive& a, ReflexReport& x) {
  auto& [event, finger, rate_N_per_s, grips, friction] = x;
  a(event, finger, rate_N_per_s, grips, friction);
}

template <typename Archive>
void members(Archive& a, ControlReport& x) {
  auto& [grasp, muscle, muscle_lack, stiffness, muscle_residual_Nm, contacts, gap_m, has_forces, centre_m,
         wrench_desired, f_desired, torques_desired_Nm, reflex, task, find_s, factors_s, grasp_s, muscle_s, total_s] =
      x;
  a(grasp, muscle, muscle_lack, stiffness, muscle_residual_Nm, contacts, gap_m, has_forces, centre_m, wrench_desired,
    f_desired, torques_desired_Nm, reflex, task, find_s, factors_s, grasp_s, muscle_s, total_s);
}

template <typename Archive>
void members(Archive& a, Run& x) {
  auto& [state, memory, frame, controller, report, controlled, random, under_way] = x;
  a(state, memory, frame, controller, report, controlled, random, under_way);
}

}  // namespace thenar
