#pragma once

#include <nlohmann/json.hpp>

#include "engine/grasp/model.h"
#include "engine/results/recording.h"

namespace thenar {

/// How this library was built: type, flags, compiler, version, and of which source (a commit, where git knows it).
[[nodiscard]] nlohmann::ordered_json build_settings();

/// How both loops were asked to run: rates, delay of the frames, when a contact solve stops.
[[nodiscard]] nlohmann::ordered_json loop_settings(const Scene& scene);

/// A ledger's terms, and what is missing from its balance [J].
[[nodiscard]] nlohmann::ordered_json ledger_json(const Ledger& ledger);
/// A verdict: {"outcome", "reason", "held", "lost_at_s", "beyond": what limits were passed, and by how much}.
[[nodiscard]] nlohmann::ordered_json verdict_json(const Verdict& verdict);

/// The measures of a run, as summary.json has them: units in the keys, null where there was nothing to measure.
///
/// From 0.3 s on, when the grip has built up: position and rotation errors, least margin, largest sliding share and
/// creep, contact counts. Over the last 0.3 s: the final errors. Slip and spin of the fingers' patches: since their
/// first contact; `start_` is the part before 0.3 s, `max_` the worst finger's. Ledger: since the start. Warnings:
/// engine/results/warnings.h. Parts: what `model: auto` left out or not, and why, a line each. Stage times: over the
/// ticks that ran the stage, null if none did. Touch, environment and reflex: of scenes that name them
/// alone.
[[nodiscard]] nlohmann::ordered_json summarize(const Model& model, const Recording& recording);

}  // namespace thenar
