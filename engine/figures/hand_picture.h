// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/hand/hand.h"

namespace thenar {

/// A gnuplot script that draws a hand alone as a PNG, its joints in the middle of their ranges: the palm and the bones
/// with their pulps, from in front of the palm and from the side.
[[nodiscard]] std::string hand_picture_script(const Hand& hand);

}  // namespace thenar
