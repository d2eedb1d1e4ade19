#pragma once

#include "engine/grasp/contact_tick.h"

namespace thenar {

/// The deformation's part of the ledger, when u has moved by a step, or `at_once` as far as the forces press it; and the
/// energies of the pulps and of a soft object.
void book_deformation(const Model& model, const Frame& frame, const ContactWorkspace& work, bool at_once, State& state,
                      Ledger& ledger);

}  // namespace thenar
