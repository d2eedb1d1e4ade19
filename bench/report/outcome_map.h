// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/results/recording.h"
#include "engine/results/verdict.h"

namespace thenar {

/// So many values from low to high, each the same number of times the one before.
[[nodiscard]] std::vector<double> equal_ratios(double low, double high, int count);

/// A setting of a scene and the values that it takes, from low to high by equal ratios.
struct MapAxis {
  std::string key, unit;
  double low = 0.0, high = 0.0;
  std::string label;
  /// What is shown for a value; nothing: the value itself.
  std::function<double(double)> shown = {};
  /// How a value is written in a scene; nothing: with the unit.
  std::function<std::string(double)> written = {};

  [[nodiscard]] std::vector<double> values(int count) const { return equal_ratios(low, high, count); }
  [[nodiscard]] double show(double value) const { return shown ? shown(value) : value; }
};

/// A line in a panel, in what the axes show.
struct MapLimit {
  std::string label;
  std::vector<double> x, y;
};

struct MapPanel {
  std::string name;
  bool ours = false;
  std::function<Recording(const Model&)> run;
  std::vector<MapLimit> limits = {};
};

/// What becomes of a grasp over two settings, by several methods on the same scenes.
struct OutcomeMap {
  std::string id, title, caption;
  MapAxis x, y;
  std::vector<std::string> overrides;
  std::function<void(Model&)> adapt = {};  ///< What follows from the settings, so that no other limit is met before.
  std::vector<MapPanel> panels;
  std::optional<std::array<double, 2>> reference = {};  ///< Where the scene itself is, as shown.
  std::string scene = "box_grasp";                      ///< Of configs.
};

/// Runs all cells, count x count of them, on all cores, and appends the figure to the part. Its caption ends with how
/// many cells each panel holds. Throws std::logic_error if a cell fails without a reason.
void add_map(nlohmann::ordered_json& part, const OutcomeMap& map, int count);

/// One method's verdict on a scene of its own: borrowed from `model` is all but its settings.
[[nodiscard]] Verdict run_and_judge(const Model& model, const std::function<Recording(const Model&)>& run);

}  // namespace thenar
