// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/hand/hand.h"

namespace thenar::app {

/// Returns "9 joints and 3 that follow".
[[nodiscard]] std::string joint_count(const Hand& hand);

/// Returns a hand in words: fingers, joints, pulps, muscles with their moment arms, which fingers can face each other,
/// and warnings.
[[nodiscard]] std::string hand_list(const Hand& hand, const std::string& name);

}  // namespace thenar::app
