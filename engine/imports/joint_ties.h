// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/hand/coupled_joints.h"
#include "engine/imports/body_tree.h"
#include "engine/imports/finger_chains.h"

namespace thenar {

/// Gives hinges without limits those that follow from the couplings to hinges with limits, along chains of couplings.
[[nodiscard]] BodyTree limited_by_ties(BodyTree tree);

/// Couples the hand's joints by the chains' ties, with notes. Of coupled joints the one nearest to the palm leads.
/// Throws ConfigError for ties that a finger cannot have: between fingers, redundant ones, disjoint ranges.
[[nodiscard]] Hand tied(Hand hand, const BodyTree& tree, const FingerChains& chains, std::vector<std::string>& notes);

}  // namespace thenar
