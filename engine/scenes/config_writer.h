// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "engine/hand/hand.h"
#include "engine/scenes/visitor.h"

namespace thenar {

/// A YAML file of a description: `show` gets a visitor that writes. A value that a file has without naming it is left
/// out, and a map without keys. Maps below the first level are written in a line where that is short. `hand` tells the
/// joints of each finger, where a key has a number for each joint.
[[nodiscard]] std::string config_text(const std::function<void(Visitor&)>& show, const Hand* hand = nullptr);

/// Words as comment lines of at most 120 columns; nothing for none.
[[nodiscard]] std::string yaml_comment(const std::string& words);

}  // namespace thenar
