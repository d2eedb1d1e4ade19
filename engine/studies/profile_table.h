#pragma once

#include <nlohmann/json.hpp>
#include <string>

/// What built the program and what the contact thread was granted: "…, SCHED_FIFO 80, core 1, memory locked".
[[nodiscard]] std::string build_line(const nlohmann::ordered_json& report);

/// The rates, times and lateness of both loops, of a profile or of a real-time run.
[[nodiscard]] std::string loops_table(const nlohmann::ordered_json& profile);

/// A latency profile as one table for people: build and scheduling, the loops' times beside the accuracy that they
/// bought, the exchange between the loops, and what the machine can do at best, where that was measured.
[[nodiscard]] std::string profile_table(const nlohmann::ordered_json& profile);
