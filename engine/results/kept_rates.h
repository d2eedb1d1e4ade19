// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace thenar {

/// Why the two loops of a run did not keep their rates, and what would mend it: a sentence for each loop that left out
/// more than a hundredth of its ticks. It names what took longer than the period (the tick itself, its tail, or the
/// start of the thread), the stage that takes the most, and a rate that the measured times allow. The list is empty if
/// both loops kept their rates. `summary` is that of a real-time run, with `loops` and `settings`.
[[nodiscard]] std::vector<std::string> rates_not_kept(const nlohmann::ordered_json& summary);

}  // namespace thenar
