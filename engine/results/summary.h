// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/results/recording.h"
#include "engine/results/run_measures.h"

namespace thenar {

/// Returns how this library was built: type, flags, compiler, version, and of which source (a commit, where git knows
/// it).
[[nodiscard]] nlohmann::ordered_json build_settings();

/// Returns the settings of both loops: rates, delay of the frames, when a contact solve stops.
[[nodiscard]] nlohmann::ordered_json loop_settings(const Scene& scene);

/// Returns a ledger's terms, and the error of its balance [J].
[[nodiscard]] nlohmann::ordered_json ledger_json(const Ledger& ledger);

/// Returns a verdict: {"outcome", "reason", "held", "lost_at_s", "beyond": what limits were passed, and by how much}.
[[nodiscard]] nlohmann::ordered_json verdict_json(const Verdict& verdict);

/// Returns a measure as files have it: null where there is nothing.
[[nodiscard]] nlohmann::ordered_json to_json(const MeasureValue& value);

/// Returns the measures of a run, as summary.json has them.
[[nodiscard]] nlohmann::ordered_json summary_json(const std::vector<MeasuredSection>& measures);
/// Returns the summary of a run that has just ended.
[[nodiscard]] nlohmann::ordered_json summarize(const Model& model, const Recording& recording);

}  // namespace thenar
