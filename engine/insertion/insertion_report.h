// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/insertion/insertion.h"

namespace thenar {

/// Returns the course of an insertion in words and a table.
[[nodiscard]] std::string insertion_text(const Scene& scene, const InsertionStudy& study);
/// Returns all its results.
[[nodiscard]] nlohmann::ordered_json insertion_json(const Scene& scene, const InsertionStudy& study);
/// Returns its ticks, a row each; below them the theory's poses, whose columns begin with theory_ and are else empty.
[[nodiscard]] std::string insertion_csv(const InsertionStudy& study);

/// Describes its end: "wedged at 3.1 mm: two contacts within the friction cones".
[[nodiscard]] std::string end_in_words(const InsertionStudy& study);

}  // namespace thenar
