// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/control/control_period.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// Runs one control period on a snapshot: pose error -> PID -> desired wrench -> grasp forces -> joint torques ->
/// muscle forces, as published except for functions in `controller.own`; contact finding; and the frame for the contact
/// tick: contacts, factors and drive at the snapshot. Without a solution of the force problem, a status, the last are
/// kept.
ControlReport control_tick(const Model& model, const ContactSnapshot& snapshot, Controller& controller, Frame& frame);

}  // namespace thenar
