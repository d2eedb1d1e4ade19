#pragma once

#include "engine/finder/found_grasp.h"
#include "engine/finder/oppositions.h"

namespace thenar {

/// A finger less dexterous than this is as good as stretched: see dexterity().
inline constexpr double kLeastDexterity = 0.06;

/// Finds the way in which the fingers carry the object best, and what it takes: fills in the grasp's `travel`. The
/// object does not turn, and pulps roll on it, as those of quasi-static fingers do whose contacts stick.
void add_travel(const FinderProblem& problem, const Hand& hand, const PatchMeter& patches, FoundGrasp& grasp);

}  // namespace thenar
