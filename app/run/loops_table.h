// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace thenar::app {

/// The part of a real-time run's summary.json that is about its two loops, as tables for people: what the threads were
/// granted, rates, times and lateness beside the accuracy that they bought, the exchange between the loops, and what
/// the machine can do at best, where that was measured.
[[nodiscard]] std::string loops_table(const nlohmann::ordered_json& summary);

}  // namespace thenar::app
