// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/finder/found_grasp.h"
#include "engine/finder/oppositions.h"

namespace thenar {

/// A finger of less dexterity counts as stretched: see dexterity().
inline constexpr double kLeastDexterity = 0.06;
/// Distance that a grasp should carry its object.
inline constexpr double kCarry_m = 20e-3;

/// Finds the direction in which the fingers carry the object farthest, with the effort there: sets the grasp's `travel`
/// fields. The object does not rotate, and pulps roll on it, as with quasi-static fingers whose contacts stick.
void add_travel(const FinderProblem& problem, const Hand& hand, const PatchMeter& patches, FoundGrasp& grasp);

}  // namespace thenar
