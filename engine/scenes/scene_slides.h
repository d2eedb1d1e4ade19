#pragma once

#include <string>

#include "engine/grasp/scene.h"
#include "engine/scenes/config.h"

namespace thenar {

/// What the list `hand.slides` of a scene says: its slides, and the hand that they are.
void read_slides(const ConfigMap& hand, Scene& scene);

/// The same as text, below `hand`.
[[nodiscard]] std::string slides_text(const Scene& scene);

}  // namespace thenar
