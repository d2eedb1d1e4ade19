// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "engine/figures/profile_figures.h"
#include "engine/grasp/model.h"
#include "engine/loops/threads.h"

namespace thenar::app {

/// Least start jitter of the machine.
struct MeasuredFloor {
  nlohmann::ordered_json json;  ///< As `floor` in summary.json; null: not measured.
  JitterFloor jitter;           ///< All start jitters, for the figure.
};

/// Measures the floor: short runs of the scene without a spin and runs of cyclictest in turns, so that both meet the
/// same other programs. `settings` are those of the run that follows. Without cyclictest, or where it is refused what
/// the contact thread is granted, it prints a warning on stderr, and nothing is measured.
[[nodiscard]] MeasuredFloor measure_floor(const Model& model, ThreadSettings settings);

}  // namespace thenar::app
