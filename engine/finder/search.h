// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "engine/finder/fit.h"
#include "engine/finder/found_grasp.h"
#include "engine/finder/hand_room.h"
#include "engine/finder/oppositions.h"
#include "engine/finder/pinch.h"

namespace thenar {

/// Evidence of a search with one set of fingers, from which a refusal derives its reason.
struct SearchEvidence {
  PinchRange range;
  Oppositions oppositions;
  Stance nearest;            ///< The fit with the least faults.
  FitTarget nearest_target;  ///< Its target.
  FitFaults nearest_faults;  ///< Its faults.
  bool has_nearest = false;
  double best_margin = -1.0;  ///< Best margin of fits without faults.
  /// Of the stances that fit, or without these of the starts, whose hand reaches into a body of the environment, the
  /// least reach.
  std::optional<HandReach> least_reach = {};
  /// Of the fits that hold by contact forces, and by no muscle forces, the one with the best margin.
  std::optional<FoundGrasp> beyond_muscles = {};
};

/// Searches with all fingers of `hand`, the grasp's alone. Adds to the report; grasps are not yet sorted.
[[nodiscard]] SearchEvidence search(const FinderProblem& problem, const Hand& hand, const FinderSettings& settings,
                                    const FinderProgress& progress, FinderReport& report);

/// Returns why a search is pointless, if that is known beforehand.
[[nodiscard]] std::optional<Refusal> refusal_at_once(const FinderProblem& problem);

/// Explains why a search found nothing, with a remedy.
[[nodiscard]] Refusal refusal_of(const FinderProblem& problem, const Hand& hand, const SearchEvidence& evidence);

}  // namespace thenar
