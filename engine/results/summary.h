#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/results/recording.h"
#include "engine/results/run_measures.h"

namespace thenar {

/// How this library was built: type, flags, compiler, version, and of which source (a commit, where git knows it).
[[nodiscard]] nlohmann::ordered_json build_settings();

/// How both loops were asked to run: rates, delay of the frames, when a contact solve stops.
[[nodiscard]] nlohmann::ordered_json loop_settings(const Scene& scene);

/// A ledger's terms, and what is missing from its balance [J].
[[nodiscard]] nlohmann::ordered_json ledger_json(const Ledger& ledger);

/// A verdict: {"outcome", "reason", "held", "lost_at_s", "beyond": what limits were passed, and by how much}.
[[nodiscard]] nlohmann::ordered_json verdict_json(const Verdict& verdict);

/// A measure as files have it: null where there is nothing.
[[nodiscard]] nlohmann::ordered_json to_json(const MeasureValue& value);

/// The measures of a run, as summary.json has them.
[[nodiscard]] nlohmann::ordered_json summary_json(const std::vector<MeasuredSection>& measures);
/// The same of a run that has just ended.
[[nodiscard]] nlohmann::ordered_json summarize(const Model& model, const Recording& recording);

}  // namespace thenar
