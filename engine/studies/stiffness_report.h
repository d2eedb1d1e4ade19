#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/studies/stiffness_probe.h"
#include "engine/studies/stiffness_range.h"

namespace thenar {

/// A study of a scene's stiffness in words,
[[nodiscard]] std::string stiffness_text(const Scene& scene, const StiffnessStudy& study);
/// and all its figures.
[[nodiscard]] nlohmann::ordered_json stiffness_json(const Scene& scene, const StiffnessStudy& study);

/// What is in the way of more: "rotation about (0.98, 0.10, -0.17) ends it, with APL, EPB at their limits".
[[nodiscard]] std::string end_in_words(const Hand& hand, const StiffnessReport& beyond);
/// What muscles could make of a grasp in words, a line each,
[[nodiscard]] std::vector<std::string> range_lines(const Hand& hand, const StiffnessRange& range);
/// and all figures of it.
[[nodiscard]] nlohmann::ordered_json range_json(const Hand& hand, const StiffnessRange& range);

}  // namespace thenar
