// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "engine/finder/fit.h"
#include "engine/finder/found_grasp.h"
#include "engine/finder/oppositions.h"

namespace thenar {

/// Estimates the fingers' normal loads before contacts are known: those of an opposition under the internal force.
[[nodiscard]] PerFinger<double> expected_loads_N(const FinderProblem& problem, const Hand& hand, int opposer);

/// Returns the cost of a grasp: first whether it holds, then its strain.
[[nodiscard]] double cost_of(const FoundGrasp& grasp);

/// Rates a stance as a grasp: contacts, forces, margin, effort and cost. `hand` has only the grasp's fingers. The
/// carried distance is left out: add_travel() adds it, and without it a grasp has a high cost.
[[nodiscard]] FoundGrasp rate(const FinderProblem& problem, const Hand& hand, const PatchMeter& patches,
                              const Stance& stance, const FitTarget& target, StanceFit& fit);

/// Tests whether two grasps are alike: the same fingers hold the object on about the same line, from the thumb's side
/// to that of the others, and approach it in about the same direction.
[[nodiscard]] bool alike(const FoundGrasp& a, const FoundGrasp& b);

}  // namespace thenar
