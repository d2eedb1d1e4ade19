#pragma once

#include <string>

#include "engine/control/task_run.h"
#include "engine/grasp/scene.h"

namespace thenar {

/// Why a phase of the scene's task has failed: "phase 3, lift, failed at 1.204 s: the fingers bear 0.41 N,
/// and the object weighs 0.98 N". Requires a fault.
[[nodiscard]] std::string in_words(const Scene& scene, const TaskReport& task);

}  // namespace thenar
