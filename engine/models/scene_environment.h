// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "collision/solids/solid_contacts.h"
#include "engine/grasp/scene.h"

namespace thenar {

/// Refuses an object that its environment leaves no room: ConfigError. `sampled`: what stands for one that is no exact
/// solid.
void check_room(const Scene& scene, const std::shared_ptr<const SampledSolid>& sampled);

}  // namespace thenar
