// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/hand/hand.h"

namespace thenar {

/// Computes the possible motion of each fingertip against the object from a frame's snapshot to the end of its use, a
/// control period and delay later [m]: the first-order motion |d| + r |turn| of the pulp that the frame's drive leaves
/// when the last forces of contact are taken from it, and the most that another finger may push the object. Zero for a
/// grip at rest. `frame` has its drive; `pose` is the hand's at the snapshot. At most the size of the object.
[[nodiscard]] PerFinger<double> finger_travel_m(const Model& model, const HandPose& pose, const Snapshot& snapshot,
                                                const Frame& frame);

}  // namespace thenar
