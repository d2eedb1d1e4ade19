#pragma once

#include <string>
#include <vector>

#include "engine/hand/coupled_joints.h"
#include "engine/imports/body_tree.h"
#include "engine/imports/finger_chains.h"

namespace thenar {

/// Makes the hand's joints follow each other as the chains' ties say, and says so in the notes. Of all joints that are
/// tied to each other the one nearest to the palm leads. Refuses with ConfigError what a finger cannot have: a tie
/// between fingers, one too many, joints whose ranges do not meet.
[[nodiscard]] Hand tied(Hand hand, const BodyTree& tree, const FingerChains& chains, std::vector<std::string>& notes);

}  // namespace thenar
