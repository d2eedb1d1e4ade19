#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/control/task_run.h"
#include "engine/results/recording.h"

namespace thenar {

/// Why a phase of the scene's task has failed: "phase 3, lift, failed at 1.204 s: the fingers bear 0.41 N,
/// and the object weighs 0.98 N". Requires a fault.
[[nodiscard]] std::string in_words(const Scene& scene, const TaskReport& task);

/// How a task in phases went: when each began and ended; of the load phase, whether grip and load rose together; what
/// the fingers bore as the object came off, and how it moved then.
[[nodiscard]] nlohmann::ordered_json task_measures(const Scene& scene, const Recording& recording);

}  // namespace thenar
