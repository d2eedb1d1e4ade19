// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/results/recording.h"

namespace thenar {

// Runs of scenes with touch, for the report.

using Texts = std::vector<std::string>;
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A scene of configs, whose object has 6000 samples.
[[nodiscard]] Scene coarse_scene(const std::string& name, Texts changes);

[[nodiscard]] Recording run(const Model& model);
[[nodiscard]] Recording run(const std::string& name, const Texts& changes);

/// All that is known is so old.
[[nodiscard]] Texts late(double ms, Texts more = {});

/// The most that a finger had slipped by then, after the grip had built up.
[[nodiscard]] double slip_mm(const Recording& recording, double until_s = std::numeric_limits<double>::infinity());

/// Appends a figure of linear axes, a run a point.
void add_run_curves(nlohmann::ordered_json& part, const std::string& id, const std::string& title,
                    const std::string& caption, const std::string& x, const std::string& y,
                    const nlohmann::ordered_json& panels);

}  // namespace thenar
