#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/studies/hand_capacity.h"

namespace thenar {

/// What a hand can give, in words for a terminal, beside what people can.
[[nodiscard]] std::string capacity_text(const HandGrip& grip, const HandCapacity& capacity);

/// The same as numbers: docs/guide/hands.md.
[[nodiscard]] nlohmann::ordered_json capacity_json(const HandGrip& grip, const HandCapacity& capacity);

}  // namespace thenar
