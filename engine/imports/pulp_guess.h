#pragma once

#include <string>
#include <vector>

#include "engine/hand/hand.h"

namespace thenar {

/// Gives each fingertip whose normal is zero one: across the last bone, to the side that turns towards the first
/// fingertip, of the first one towards the others, of a single one towards the origin, while all joints are in the
/// middle of their ranges; and tilted by 20 degrees towards the tip, as in configs/hand.yaml. Notes say so.
void guess_normals(Hand& hand, std::vector<std::string>& notes);

}  // namespace thenar
