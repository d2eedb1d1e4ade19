#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/studies/stiffness_probe.h"

namespace thenar {

/// A study of a scene's stiffness in words,
[[nodiscard]] std::string stiffness_text(const Scene& scene, const StiffnessStudy& study);
/// and all its figures.
[[nodiscard]] nlohmann::ordered_json stiffness_json(const Scene& scene, const StiffnessStudy& study);

}  // namespace thenar
