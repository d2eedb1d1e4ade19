// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/hand/hand.h"

namespace thenar {

/// Guesses the normal of each fingertip that has none: across the last bone, towards the first fingertip, for the first
/// one towards the others, for a single one towards the origin, with all joints in the middle of their ranges; and
/// tilted by 20 degrees towards the tip, as in configs/hand.yaml. Adds notes.
void guess_normals(Hand& hand, std::vector<std::string>& notes);

}  // namespace thenar
