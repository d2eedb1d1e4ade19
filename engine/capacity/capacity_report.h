// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/capacity/hand_capacity.h"

namespace thenar {

/// Describes the capacity of a hand for a terminal, beside that of people.
[[nodiscard]] std::string capacity_text(const HandGrip& grip, const HandCapacity& capacity);

/// Returns the same as numbers: docs/guide/hands.md.
[[nodiscard]] nlohmann::ordered_json capacity_json(const HandGrip& grip, const HandCapacity& capacity);

}  // namespace thenar
