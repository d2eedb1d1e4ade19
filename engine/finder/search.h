#pragma once

#include <optional>
#include <vector>

#include "engine/finder/fit.h"
#include "engine/finder/found_grasp.h"
#include "engine/finder/oppositions.h"
#include "engine/finder/pinch.h"

namespace thenar {

/// What a search with one set of fingers saw, from which a refusal takes its reason.
struct SearchEvidence {
  PinchRange range;
  Oppositions oppositions;
  Stance nearest;            ///< The fit with the least faults,
  FitTarget nearest_target;  ///< what it was for,
  FitFaults nearest_faults;  ///< and what they are.
  bool has_nearest = false;
  double best_margin = -1.0;  ///< Of fits without faults.
};

/// Searches with all fingers of `hand`, the grasp's alone. Adds to the report; grasps are not yet sorted.
[[nodiscard]] SearchEvidence search(const FinderProblem& problem, const Hand& hand, const FinderSettings& settings,
                                    const FinderProgress& progress, FinderReport& report);

/// Why there is nothing to search for, if that is plain before.
[[nodiscard]] std::optional<Refusal> refusal_at_once(const FinderProblem& problem);

/// Why a search found nothing, and what would help.
[[nodiscard]] Refusal refusal_of(const FinderProblem& problem, const Hand& hand, const SearchEvidence& evidence);

}  // namespace thenar
