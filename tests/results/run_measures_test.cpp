// SPDX-License-Identifier: Apache-2.0
#include "engine/results/run_measures.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "tests/support/scenes.h"

namespace thenar::run_measures_test {
namespace {

using nlohmann::ordered_json;
using Names = std::set<std::string>;

std::string join(const std::string& within, std::string_view key) {
  return within.empty() ? std::string(key) : within + "." + std::string(key);
}

/// What the rows say that the summary of a run has.
Names names_of_rows(const RunView& view) {
  Names names;
  for (const MeasureSection& section : measure_sections()) {
    if (section.heading == Heading::kSweepAlone || !section.runs->have(view)) continue;
    RunView item = view;
    const std::size_t items = section.items != nullptr ? section.items(view) : 1;
    if (items == 0) names.insert(std::string(section.key));
    for (item.item = 0; item.item < items; ++item.item) {
      for (const RunMeasure& measure : section.measures) {
        if (measure.is_in(item)) names.insert(join(std::string(section.key), measure.key));
      }
    }
  }
  return names;
}

/// The leaves of a summary by the keys on their way; objects of a list share theirs, and the percentiles of a stage are
/// one measure.
void add_leaves(const ordered_json& json, const std::string& name, Names& names) {
  if (json.is_array() && !json.empty() && json.front().is_object()) {
    for (const ordered_json& one : json) add_leaves(one, name, names);
  } else if (json.is_object() && !json.contains("p50_us")) {
    for (const auto& [key, value] : json.items()) add_leaves(value, join(name, key), names);
  } else {
    names.insert(name);
  }
}

// Scenes that have, all together, each section; runs of 20 ms.
TEST(RunMeasures, ASummaryHasTheKeysOfItsRowsAndNoOther) {
  for (const char* name : {"minimal", "box_stiff", "box_wet", "pick_and_place", "slides_ball"}) {
    SCOPED_TRACE(name);
    const Model model = build_model(scene_of(name, {"time.duration=20 ms"}));
    State state(model);
    const Recording recording = run_scene(model, state);
    Names names;
    add_leaves(summarize(model, recording), "", names);
    EXPECT_EQ(names, names_of_rows(view_of(model, recording)));
  }
}

TEST(RunMeasures, EveryRowHasASentenceAndANameOfItsOwn) {
  Names names;
  for (const MeasureSection& section : measure_sections()) {
    for (const RunMeasure& measure : section.measures) {
      const std::string name = join(std::string(section.key), measure.key);
      EXPECT_TRUE(measure.sentence.ends_with('.')) << name;
      EXPECT_EQ(measure.sentence.find('|'), std::string_view::npos) << name << ": it is a cell of a table";
      EXPECT_TRUE(names.insert(name).second) << name;
    }
  }
}

TEST(RunMeasures, ColumnsHaveAPlaceAndANameOfTheirOwn) {
  Names names;
  int place = 0;
  for (const RunMeasure* const measure : sweep_measures()) {
    EXPECT_EQ(measure->column, ++place) << measure->key;
    EXPECT_TRUE(names.insert(measure->column_name()).second) << measure->key;
  }
}

// A verdict, a ledger and settings that come without a run are the parts of a summary with these names.
TEST(RunMeasures, APartHasTheSameBytesAsInTheSummary) {
  const Model model = build_model(scene_of("minimal", {"time.duration=20 ms"}));
  State state(model);
  const Recording recording = run_scene(model, state);
  const ordered_json summary = summarize(model, recording);
  EXPECT_EQ(summary.at("build").dump(), build_settings().dump());
  EXPECT_EQ(summary.at("ledger").dump(), ledger_json(recording.ticks.back().ledger).dump());
  const ordered_json verdict = verdict_json(recording.verdict), settings = loop_settings(model.scene);
  for (const auto& [key, value] : verdict.items()) EXPECT_EQ(summary.at("grasp").at(key), value) << key;
  for (const auto& [key, value] : settings.items()) EXPECT_EQ(summary.at("settings").at(key), value) << key;
}

}  // namespace
}  // namespace thenar::run_measures_test
