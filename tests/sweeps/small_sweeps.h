// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scenes/scene_file.h"
#include "engine/scenes/units.h"
#include "engine/sweeps/sweep.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

/// Sweeps of few rows.
namespace thenar::small_sweeps {

namespace fs = std::filesystem;
using Texts = std::vector<std::string>;

/// A scene whose surface is soon there, until it is measured.
inline SweepPlan small_plan(const Texts& vary) {
  SweepPlan plan{config_file("minimal"), {"object.points=2000", "time.duration=0.32 s"}, {}};
  for (const std::string& text : vary) plan.vary.push_back(read_variation(text));
  return plan;
}

/// A copy of a scene and its hand, to be changed.
inline fs::path copied_scene(const fs::path& folder, const std::string& hand = "hand.yaml") {
  fs::create_directories(folder);
  fs::copy_file(config_file("hand"), folder / hand);
  std::string text = read(config_file("minimal"));
  const std::string shipped = "hand.yaml";
  text.replace(text.find(shipped), shipped.size(), hand);
  std::ofstream(folder / "minimal.yaml") << text;
  return folder / "minimal.yaml";
}

/// The table of these rows.
inline std::string rows_csv(const SweepPlan& plan, const std::map<std::size_t, SweepRow>& rows) {
  std::string csv;
  write_rows_csv(
      plan, [&](std::size_t row) { return rows.contains(row) ? std::optional(rows.at(row)) : std::nullopt; },
      [&](std::string_view part) { csv += part; });
  return csv;
}

inline SweepRow row_of(Outcome outcome, const std::string& reason, const std::string& measures) {
  SweepRow row;
  row.verdict = {outcome, reason};
  row.measures = nlohmann::ordered_json::parse(measures);
  return row;
}

}  // namespace thenar::small_sweeps
