// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/stiffness/stiffness_probe.h"
#include "engine/stiffness/stiffness_range.h"

namespace thenar {

/// Describes a study of a scene's stiffness.
[[nodiscard]] std::string stiffness_text(const Scene& scene, const StiffnessStudy& study);
/// Returns all its results.
[[nodiscard]] nlohmann::ordered_json stiffness_json(const Scene& scene, const StiffnessStudy& study);

/// Describes the limit of stiffness: "rotation about (0.98, 0.10, -0.17) ends it, with APL, EPB at their limits".
[[nodiscard]] std::string end_in_words(const Hand& hand, const StiffnessReport& beyond);
/// Describes the range of a grasp's stiffness, line by line.
[[nodiscard]] std::vector<std::string> range_lines(const Hand& hand, const StiffnessRange& range);
/// Returns the range as numbers.
[[nodiscard]] nlohmann::ordered_json range_json(const Hand& hand, const StiffnessRange& range);

}  // namespace thenar
