#pragma once

#include <string>

#include "engine/grasp/scene.h"
#include "engine/scenes/config.h"

namespace thenar {

/// What the map `task` of a scene says, all else of which is read.
[[nodiscard]] TaskSettings read_task(const ConfigMap& root, const Scene& scene);

/// The same as text; empty if nothing is asked for.
[[nodiscard]] std::string task_text(const TaskSettings& task);

}  // namespace thenar
