// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "engine/grasp/delassus.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/hand/muscles.h"

/// Muscles in a contact tick: their activation, their short-range stiffness, and the forces with which they pull.
namespace thenar {

/// Muscles whose fibres are strained beyond the range of their stiffness, for a scene whose muscles have stiffness.
struct YieldedFibres {
  std::uint64_t muscles = 0;  ///< A bit for each of them.
  int most = -1;              ///< The most strained one; -1: none.
  double strain = 0.0;        ///< Its strain; negative: shortened.
};

/// Advances State::muscle_N by a step, exactly for the time constants of its beginning. A state that has none yet
/// begins with what the frame asks for. For a scene whose muscles act on the contact side, as the next function.
void activate(const Model& model, const Frame& frame, State& state);

/// Adds what muscles do beyond the frame's torques at the state: their forces differ from the commands, they have been
/// lengthened since, and their arms and the weight's have changed. To the first order, except that fibres yield beyond
/// their range. The joints' stiffness goes to `torque` and `stiffness`, a matrix a finger if muscles are stiff, else
/// none; each belly's stretch to `bellies`. Does not allocate.
void let_muscles_act(const Model& model, const Frame& frame, const State& state, std::span<BellyStretch> bellies,
                     JointVector& torque, PerFinger<JointMatrix>& stiffness);

/// Writes State::pull_N after a tick that has moved the joints by dq: the forces that have driven them. Returns which
/// fibres have yielded. For a scene with muscles. Does not allocate.
YieldedFibres take_pulls(const Model& model, const Frame& frame, std::span<const BellyStretch> bellies,
                         const JointVector& dq, State& state);

}  // namespace thenar
