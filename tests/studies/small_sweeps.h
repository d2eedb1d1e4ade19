#pragma once

#include <string>
#include <vector>

#include "engine/scenes/scene_file.h"
#include "engine/scenes/units.h"
#include "engine/studies/sweep.h"
#include "tests/support/scenes.h"

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
inline fs::path copied_scene(const fs::path& folder) {
  fs::create_directories(folder);
  for (const char* file : {"minimal.yaml", "hand.yaml"})
    fs::copy_file(config_file("").parent_path() / file, folder / file);
  return folder / "minimal.yaml";
}

inline SweepRow row_of(Outcome outcome, const std::string& reason, const std::string& measures) {
  SweepRow row;
  row.verdict = {outcome, reason};
  row.measures = nlohmann::ordered_json::parse(measures);
  return row;
}

}  // namespace thenar::small_sweeps
