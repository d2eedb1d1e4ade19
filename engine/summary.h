#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "engine/model.h"
#include "engine/recording.h"

namespace thenar {

/// How this library was built: type, flags, compiler, version, and of which source (a commit, where git knows it).
[[nodiscard]] nlohmann::ordered_json build_settings();

/// How both loops were asked to run: rates, delay of the frames, when a contact solve stops.
[[nodiscard]] nlohmann::ordered_json loop_settings(const Scene& scene);

/// The measures of a run, as summary.json has them: units in the keys, null where there was nothing to measure.
///
/// From 0.3 s on, when the grip has built up: position and rotation errors, slip, cone margin, contact counts. Over the
/// last 0.3 s: the final errors. Slip of a finger: the sum over ticks of the smallest |delta_t| among its loaded
/// contacts. Warnings: engine/warnings.h. Parts: what `model: auto` left out or not, and why, a line each. Stage times: over the ticks that ran
/// the stage, null if none did.
[[nodiscard]] nlohmann::ordered_json summarize(const Model& model, const Recording& recording);

/// A problem that found no answer.
struct SolveFailure {
  double time_s = 0.0;   ///< Of the first one.
  bool contact = false;  ///< It is the contact solver's, not that of grasp or muscle forces.
  std::string reason;
};

/// The first grasp-force problem without a solution, muscle-force problem without one, or contact problem that was not
/// finite; or that contact solves did not converge. Nothing if all was solved.
[[nodiscard]] std::optional<SolveFailure> solve_failure(const Model& model, const Recording& recording);

/// Why the simulation failed, in a sentence: no grasp forces exist, the object was lost, or a solver found no
/// answer. Nothing if it did not fail.
[[nodiscard]] std::optional<std::string> failure(const Model& model, const Recording& recording);

}  // namespace thenar
