#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace thenar::app {

/// The measures of a run as one table for people: build, grasp, accuracy, and time a stage beside the published times.
[[nodiscard]] std::string results_table(const nlohmann::ordered_json& summary);

}  // namespace thenar::app
