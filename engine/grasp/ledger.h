// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/grasp/contact_memory.h"
#include "engine/grasp/contact_scratch.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// Energy balance of a tick [J]. With forces held over the tick its law in generalised coordinates, B (dq, dx) /
/// h = drive + J_c' f with the drive at the tick's end, times the motion (dq, dx) is
///     drive - viscous + sum_i f_i . J_c,i (dq, dx) = 0,
/// and in each contact's rows J_c (dq, dx) = w - (u+ - u) - (u_o+ - u_o), w the relative motion of the two deformed
/// surfaces. So, over any time and to the accuracy of the solve,
///     drive - viscous - deformation + injected - dissipated = 0.
struct Ledger {
  double drive_J = 0.0;        ///< Work on the bodies other than by contact: torques, weight, springs, input.
  double viscous_J = 0.0;      ///< Taken by the bodies' viscosities.
  double deformation_J = 0.0;  ///< Work of the contact forces on the pulps and a soft object.
  double stored_J = 0.0;       ///< Elastic energy in these after the tick; the rest of that work their viscosity took.
  double injected_J = 0.0;    ///< Work of contacts whose forces push their surfaces on, f . w > 0: energy from nowhere.
  double dissipated_J = 0.0;  ///< Work of the others, mainly friction. Each contact is booked by its own sign.

  /// Part of the energy taken from `stored_J`: energy of contacts of the tick before that this one lacks, because a
  /// frame is older than the motion, or a list is full. It is in no other entry, and so not in the balance.
  double dropped_J = 0.0;

  /// Returns the error of the balance.
  [[nodiscard]] double unbalanced_J() const { return drive_J - viscous_J - deformation_J + injected_J - dissipated_J; }
  /// Adds the next tick's entries.
  void add(const Ledger& tick) {
    drive_J += tick.drive_J;
    viscous_J += tick.viscous_J;
    deformation_J += tick.deformation_J;
    stored_J = tick.stored_J;
    injected_J += tick.injected_J;
    dissipated_J += tick.dissipated_J;
    dropped_J += tick.dropped_J;
  }
};

/// Books the deformation's part, after u moved by a step, or `at_once` as far as the forces press it; and the energies
/// of the pulps and of a soft object.
void book_deformation(const Model& model, const Frame& frame, const ContactMemory& memory, const ContactScratch& work,
                      bool at_once, State& state, Ledger& ledger);

/// Books the environment's part.
void book_environment(const Environment& environment, const ContactMemory& memory, const ContactScratch& work,
                      Ledger& ledger);

}  // namespace thenar
