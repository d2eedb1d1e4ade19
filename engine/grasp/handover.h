// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/grasp/contact_memory.h"
#include "engine/grasp/contact_scratch.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// Carries forces to the contacts of a frame by finger and control point; both lists are sorted. Tangents are carried
/// by parallel transport, so the components keep their meaning, and the cone is the same. The force of a contact that
/// is no more goes to its finger's loaded ones, shared as the pulp would. f: out, 3 rows a contact.
void carry_forces(const Model& model, const Frame& frame, const std::vector<ContactForce>& forces, Eigen::VectorXd& f);

/// Takes over a new frame at a state, where `work.kinematics` has the bodies: carries the forces, finds the gaps of the
/// frame's contacts (find_gaps), and gives each contact the offset
///     e = e_old + gap_old - gap_new
/// of its gaps by the old and the new frame, both at this state and deformed, so that noise of the frame moves nothing
/// at once. A contact that the old frame did not have starts closed at the deepest, not pressed in. No offset
/// exceeds half a fingertip's radius: that is no noise. Loads on a soft object go along with their contacts.
/// Returns the elastic energy of contacts that the frame lacks [J].
double hand_over(const Model& model, const Frame& frame, State& state, ContactMemory& memory, ContactScratch& work);

}  // namespace thenar
