// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "engine/grasp/acting_muscles.h"
#include "engine/grasp/contact_memory.h"
#include "engine/grasp/contact_scratch.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/ledger.h"
#include "engine/grasp/model.h"
#include "engine/grasp/patches.h"
#include "engine/grasp/state.h"
#include "solvers/gauss_seidel.h"

namespace thenar {

/// Input of a contact tick from its caller: the interface for a haptic device.
struct TickInput {
  Vector6d wrench = Vector6d::Zero();     ///< Added to the frame's, about the object's origin, world axes [N, N m].
  std::optional<Eigen::Isometry3d> X_WT;  ///< Target of the object at this tick; nothing: the task's.
};

/// Result of one contact tick, returned by value.
struct TickReport {
  TickReport() = default;
  explicit TickReport(const Hand& hand)
      : left_out_m(hand.fingers()),
        injected_J(hand.fingers()),
        small(hand.fingers()),
        patch(hand.fingers()),
        stop_Nm(hand.at_zero()) {}

  SolveReport solve;
  std::int64_t sequence = -1;  ///< Number of the frame used.
  std::int64_t frame_age = 0;  ///< Steps from the frame's snapshot to this tick's start.
  bool handed_over = false;    ///< The frame is new.
  bool held = false;           ///< The frame is too old or too far off: its drive is held.
  bool input_refused = false;  ///< The input was not finite, and was left out.
  Ledger ledger;
  Eigen::Index contacts = 0;
  Eigen::Index active = 0;  ///< Contacts that carry force.
  /// Penetration depth of a deformed control point: a contact at the tick's end, offset or not, or one left out of the
  /// full list, at its start. For one whose cell an edge cuts, the mean over the cell.
  double penetration_m = 0.0;
  PerFinger<double> left_out_m;  ///< Depth of the latter alone, by finger; 0: none in the object.
  PerFinger<double> injected_J;  ///< Part of the ledger's from each finger's contacts.
  PerFinger<SmallPatch> small;   ///< Small patches of loaded fingers.
  PerFinger<PatchReport> patch;
  EnvironmentReport environment;  ///< Report for a scene with an environment.
  YieldedFibres yielded;          ///< Fibres at the end of the tick.
  JointVector stop_Nm;            ///< Torques of the stops at the ends of the joints' ranges: see JointStops.
  double assemble_s = 0.0;        ///< Time of hand-over, drive, gaps and Jacobians: the parts of W.
  double solve_s = 0.0;           ///< Time of free motion, Gauss-Seidel and commit.
  double deform_s = 0.0;          ///< Time of deformation and patch reports.
};

/// Advances the state by one step h of the contact loop on a frozen frame.
///
/// 1. A new frame is taken over without a bump: forces are carried, and with `policy.offset_decay_s` each gap gets the
///    offset e that makes old and new frame agree at this state, which then decays.
/// 2. Drive: the frame's, the input's, and the pull of the task's spring. A frame too old, or one from which the
///    fingers have moved too far, is held: tau = tau_held - K_h (q - q_held).
/// 3. Free motion of the rigid bodies, h B^-1 (tau - g, W_ext), and of the pulps, u* = rho u; a soft object likewise.
/// 4. delta_free: gaps, absolute, from the body-fixed geometry at the state (the local torus of the object's surface);
///    slips, relative to the tick. The bodies' free motion enters through J_c, as the contact motion does, so that what
///    contact forbids cancels to the last bit.
/// 5. Contact forces by Gauss-Seidel on W(h) in factors, J_c of this state, from the forces of the last tick. A soft
///    object couples all contacts: then W is formed, with (1 - rho_o) C_o.
/// 6. Commit: (q, x) moves by h B^-1 (drive + J_c' f), u = rho u + (1 - rho) C f. What is not finite moves nothing, and
///    the status says so.
/// 7. Reports: motion of the loaded points of each patch, and the energy ledger.
///
/// A state without forces and deformation whose pulps lie in the object when the workspace's first frame comes begins
/// with the pulps pressed in as far, bodies at rest: the energy of that is the start's, and no contact injects it.
///
/// Does not allocate after the first call on a state. Does not lock, log or throw.
TickReport contact_tick(const Model& model, const Frame& frame, ContactMemory& memory, ContactScratch& work,
                        State& state, const TickInput& input = {}) noexcept;

/// Returns the loads on the pulps of a new state, pressed in and sheared, at the start of its first tick. Allocates.
[[nodiscard]] PerFinger<FingerLoad> first_loads(const Model& model, const Frame& frame);

}  // namespace thenar
