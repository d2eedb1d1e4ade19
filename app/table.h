#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/results/run_measures.h"

namespace thenar::app {

/// The measures of a run as one table for people, heading by heading; with what the loops of a run in real time did,
/// as a profile has it.
[[nodiscard]] std::string results_table(const std::vector<MeasuredSection>& measures,
                                        const nlohmann::ordered_json& loops);

}  // namespace thenar::app
