// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "engine/environment/environment_contacts.h"
#include "engine/grasp/contact_memory.h"
#include "engine/grasp/contact_scratch.h"
#include "engine/grasp/delassus.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

// Steps of a contact tick for a scene with an environment. `wrench` drives the object beside contact, about its origin,
// world axes.

namespace thenar {

/// Finds the object's contacts beside the fingers, as far as the drive might move it in the tick; or after a motion of
/// it, and the tick.
void look_around(const Model& model, const Mobility& mobility, const Vector6d& wrench, const State& state,
                 EnvironmentContacts& contacts, const std::optional<Vector6d>& after_motion = std::nullopt);

/// Looks again from where the motion x, which the tick has found, takes the object. True if contacts were missed:
/// the tick is then to be solved again with the new work.environment.
[[nodiscard]] bool look_again(const Model& model, const Mobility& mobility, const Vector6d& wrench, const State& state,
                              const Vector6d& x, ContactMemory& memory, ContactScratch& work);

/// Returns the object on its environment before any finger touches it; nothing without one.
[[nodiscard]] std::optional<CommonGround> ground_of(const Model& model, const Mobility& mobility,
                                                    const Vector6d& wrench, const EnvironmentContacts& contacts);

/// Keeps the environment's forces for the next tick, which begins where the state is now, and tells of them.
void keep_environment(const ContactMemory& memory, const ContactScratch& work, State& state, EnvironmentReport& report);

}  // namespace thenar
