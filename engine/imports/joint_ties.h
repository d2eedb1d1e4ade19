#pragma once

#include <string>
#include <vector>

#include "engine/hand/coupled_joints.h"
#include "engine/imports/body_tree.h"
#include "engine/imports/finger_chains.h"

namespace thenar {

/// Couples the hand's joints by the chains' ties, with notes. Of coupled joints the one nearest to the palm leads.
/// Throws ConfigError for ties that a finger cannot have: between fingers, redundant ones, joints whose ranges do not
/// meet.
[[nodiscard]] Hand tied(Hand hand, const BodyTree& tree, const FingerChains& chains, std::vector<std::string>& notes);

}  // namespace thenar
