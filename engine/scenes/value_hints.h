// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "engine/scenes/yaml_tree.h"

/// What people often write in the place of a value, and how it is written here. Each returns words for the end of a
/// message, or nothing.
namespace thenar {

/// ": write 100000" for a whole number that is there in another way, such as 1e5 or 2,000.
[[nodiscard]] std::string digits_hint(std::string_view text);

/// ", did you mean 'false'?" for another word for true or false.
[[nodiscard]] std::string flag_hint(std::string_view text);

/// For a list of numbers that should have `count` items, and has not.
[[nodiscard]] std::string list_hint(const YamlNode& list, int count);

/// For a number with its unit: decimal commas, and signs that only look like '-' and a blank.
[[nodiscard]] std::string quantity_hint(std::string_view text);

}  // namespace thenar
