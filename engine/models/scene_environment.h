// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "collision/implicit_surface.h"
#include "collision/solids/solid_contacts.h"
#include "engine/grasp/scene.h"

namespace thenar {

/// Returns the object as its environment touches it: exact, or `sampled` for one that is no exact solid.
[[nodiscard]] TouchingSolid touching_object(const Scene& scene, const std::shared_ptr<const SampledSolid>& sampled);

/// Gives the bodies that are under the object their poses: the top of each, which is level, touches the object's lowest
/// point, less the gap, with its middle under the centre of mass. Their x axis is the object's, made level. Requires
/// gravity, and of a scene whose grasp is to be found that gravity and environment are in the object's frame.
void stand_object(Scene& scene, const TouchingSolid& object);
void stand_object(Scene& scene, const ImplicitSurface& object);
/// Returns true if the grasp is to be found with bodies in the object's frame that have no poses yet.
[[nodiscard]] bool stands_in_object_frame(const Scene& scene);

/// Brings what a scene has in the object's frame, gravity, environment and the task's goal, into the world's, with the
/// object where the scene has it.
void place_by_object(Scene& scene);

/// Refuses an object that its environment leaves no room: ConfigError. Requires an environment in the world's frame.
/// `is_found`: the grasp was found, and with it the object's pose.
void check_room(const Scene& scene, const TouchingSolid& object, bool is_found);

}  // namespace thenar
