#pragma once

#include <string>

#include "engine/environment/environment.h"
#include "engine/grasp/scene.h"
#include "engine/scenes/config.h"

namespace thenar {

/// What the map `environment` says, for an object of this shape.
[[nodiscard]] Environment read_environment(const ConfigMap& root, const Shape& object);

/// Refuses an object that its environment leaves no room: ConfigError.
void check_room(const Scene& scene);

/// A solid in YAML, as it reads back: "{sphere: 0.01 m}".
[[nodiscard]] std::string solid_text(const Solid& solid);
/// Likewise the map.
[[nodiscard]] std::string environment_text(const Environment& environment);

}  // namespace thenar
