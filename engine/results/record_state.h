// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/loops/archive.h"
#include "engine/loops/picture.h"
#include "engine/loops/run_state.h"
#include "engine/results/grasp_monitor.h"
#include "engine/results/recorder.h"
#include "engine/results/recording.h"

/// Results of a run as bytes: the members of a tick's record and of a picture, as engine/loops/run_state.h has
/// those of the run.
namespace thenar {

template <typename Archive>
void members(Archive& a, TickInput& x) {
  auto& [wrench, X_WT] = x;
  a(wrench, X_WT);
}

template <typename Archive>
void members(Archive& a, SolveReport& x) {
  auto& [status, sweeps, residual, residual_worst] = x;
  a(status, sweeps, residual, residual_worst);
}

template <typename Archive>
void members(Archive& a, Ledger& x) {
  auto& [drive_J, viscous_J, deformation_J, stored_J, injected_J, dissipated_J, dropped_J] = x;
  a(drive_J, viscous_J, deformation_J, stored_J, injected_J, dissipated_J, dropped_J);
}

template <typename Archive>
void members(Archive& a, PatchReport& x) {
  auto& [slip_W, slip_m, spin_rad, sliding_share, creep_m_per_s, dent_O, moment_Nm, moment_limit_Nm, margin] = x;
  a(slip_W, slip_m, spin_rad, sliding_share, creep_m_per_s, dent_O, moment_Nm, moment_limit_Nm, margin);
}

template <typename Archive>
void members(Archive& a, EnvironmentReport& x) {
  auto& [contacts, active, penetration_m, wrench, normal_N, body_N, wedged] = x;
  a(contacts, active, penetration_m, wrench, normal_N, body_N, wedged);
}

template <typename Archive>
void members(Archive& a, YieldedFibres& x) {
  auto& [muscles, most, strain] = x;
  a(muscles, most, strain);
}

template <typename Archive>
void members(Archive& a, TickReport& x) {
  auto& [solve, sequence, frame_age, handed_over, held, input_refused, ledger, contacts, active, penetration_m,
         left_out_m, injected_J, small, patch, environment, yielded, stop_Nm, assemble_s, solve_s, deform_s] = x;
  a(solve, sequence, frame_age, handed_over, held, input_refused, ledger, contacts, active, penetration_m, left_out_m,
    injected_J, small, patch, environment, yielded, stop_Nm, assemble_s, solve_s, deform_s);
}

template <typename Archive>
void members(Archive& a, NormalTangential& x) {
  auto& [normal_N, tangential_N] = x;
  a(normal_N, tangential_N);
}

template <typename Archive>
void members(Archive& a, LastReflex& x) {
  auto& [event, finger, time_s] = x;
  a(event, finger, time_s);
}

template <typename Archive>
void members(Archive& a, StiffnessRecord& x) {
  auto& [report, torques_Nm] = x;
  a(report, torques_Nm);
}

template <typename Archive>
void members(Archive& a, KnownStiffness& x) {
  auto& [now, chosen, lacked, lacked_s] = x;
  a(now, chosen, lacked, lacked_s);
}

template <typename Archive>
void members(Archive& a, TickRecord& x) {
  auto& [time_s, controlled, phase, holds, arm_m, borne_N, X_WT, position_m, target_m, rotation_error_rad, X_WO, q_rad,
         torques_Nm, load, force, force_desired, desired_N, force_error_N, margin, sliding_share, creep_m_per_s, slip_m,
         spin_rad, start_slip_m, start_spin_rad, walk_m, turn_rad, touch, reflex, last_reflex, stiffness, ledger,
         contact, interpolate_s, find_s, factors_s, grasp_s, muscle_s, control_s, grasp, muscle, muscle_residual_Nm] =
      x;
  a(time_s, controlled, phase, holds, arm_m, borne_N, X_WT, position_m, target_m, rotation_error_rad, X_WO, q_rad,
    torques_Nm, load, force, force_desired, desired_N, force_error_N, margin, sliding_share, creep_m_per_s, slip_m,
    spin_rad, start_slip_m, start_spin_rad, walk_m, turn_rad, touch, reflex, last_reflex, stiffness, ledger, contact,
    interpolate_s, find_s, factors_s, grasp_s, muscle_s, control_s, grasp, muscle, muscle_residual_Nm);
}

template <typename Archive>
void members(Archive& a, UnsolvedGrasp& x) {
  auto& [time_s, control] = x;
  a(time_s, control);
}

template <typename Archive>
void members(Archive& a, ShownContact& x) {
  auto& [finger, control_point, point_m, normal, force_N, normal_N, friction_N, share, slip_m_per_s] = x;
  a(finger, control_point, point_m, normal, force_N, normal_N, friction_N, share, slip_m_per_s);
}

template <typename Archive>
void members(Archive& a, ShownTouch& x) {
  auto& [body, point_E, normal, force_N] = x;
  a(body, point_E, normal, force_N);
}

/// Of an instant that nobody pulls at.
template <typename Archive>
void members(Archive& a, Picture& x) {
  a(x.step_s, x.snapshot, x.u_m, x.contacts, x.touches);
}

}  // namespace thenar
