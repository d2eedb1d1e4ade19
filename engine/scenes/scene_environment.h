#pragma once

#include <memory>
#include <string>

#include "collision/solids/solid_contacts.h"
#include "engine/environment/environment.h"
#include "engine/grasp/scene.h"
#include "engine/scenes/config.h"

namespace thenar {

/// What the map `environment` says.
[[nodiscard]] Environment read_environment(const ConfigMap& root);

/// Refuses an object that its environment leaves no room: ConfigError. `sampled`: what stands for one that is no exact
/// solid.
void check_room(const Scene& scene, const std::shared_ptr<const SampledSolid>& sampled);

/// A solid in YAML, as it reads back: "{sphere: 0.01 m}".
[[nodiscard]] std::string solid_text(const Solid& solid);
/// Likewise the map.
[[nodiscard]] std::string environment_text(const Environment& environment);

}  // namespace thenar
