#pragma once

#include <optional>

#include "engine/finder/fit.h"
#include "engine/finder/found_grasp.h"
#include "engine/finder/oppositions.h"

namespace thenar {

/// What the fingers are asked for, before their places are known: the normal loads of an opposition that squeezes.
[[nodiscard]] PerFinger<double> expected_loads_N(const FinderProblem& problem, const Hand& hand, int opposer);

/// What is wanted of a grasp, in one number: first of all that it holds, then that it is at ease.
[[nodiscard]] double cost_of(const FoundGrasp& grasp);

/// The grasp that a stance is: places, forces, margin, effort and cost. `hand` has the grasp's fingers alone. The
/// travel is left out: add_travel() adds it, and without it a grasp has a high cost.
[[nodiscard]] FoundGrasp rate(const FinderProblem& problem, const Hand& hand, const PatchMeter& patches,
                              const Stance& stance, const FitTarget& target, StanceFit& fit);

/// Whether a user would call two grasps one: the same fingers hold the object on about the same line, from the thumb's
/// side to that of the others, and come to it in about the same way.
[[nodiscard]] bool alike(const FoundGrasp& a, const FoundGrasp& b);

}  // namespace thenar
