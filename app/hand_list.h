#pragma once

#include <string>

#include "engine/grasp/hand.h"

/// What a hand is, in words: fingers, joints, pulps, muscles with their moment arms, which fingers can face each other,
/// and warnings.
[[nodiscard]] std::string hand_list(const thenar::Hand& hand, const std::string& name);
