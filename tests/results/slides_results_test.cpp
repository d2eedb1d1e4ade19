// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "engine/models/build_model.h"
#include "engine/recordings/recording_scene.h"
#include "engine/recordings/signal_columns.h"
#include "engine/recordings/signals.h"
#include "engine/recordings/state_message.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "engine/results/warnings.h"
#include "tests/support/scenes.h"

/// Fingertips on slides in results: in m and N, where a hand has rad and N m.
namespace thenar::slides_results_test {
namespace {

Model ball(const std::vector<std::string>& changes = {}) {
  std::vector<std::string> all = {"time.duration=0.1 s", "object.points=4000"};
  all.insert(all.end(), changes.begin(), changes.end());
  return build_model(scene_of("slides_ball", all));
}

TEST(SlidesResults, SignalsAreInMillimetres) {
  const Model model = ball();
  State state(model);
  const Recording recording = run_scene(model, state);
  const SignalTable table = signal_table(model, recording);
  const auto at = std::ranges::find(table.names, "tip2_travel_mm");
  ASSERT_NE(at, table.names.end());
  EXPECT_EQ(table.numbers(table.numbers.rows() - 1, at - table.names.begin()), 1e3 * state.q[1]);
  EXPECT_TRUE(std::ranges::none_of(table.names, [](const std::string& name) { return name.ends_with("_rad"); }));
}

TEST(SlidesResults, FieldsOfAStateHaveTheirUnits) {
  const Model model = ball();
  const std::vector<Field> fields = state_fields(model);
  const auto unit_of = [&](const std::string& name) {
    const auto found = std::ranges::find(fields, name, &Field::name);
    return found == fields.end() ? "none" : found->unit;
  };
  EXPECT_EQ(unit_of("q_m"), "m");
  EXPECT_EQ(unit_of("stop_N"), "N");
  EXPECT_EQ(unit_of("q_rad"), "none");
  EXPECT_EQ(unit_of("stop_Nm"), "none");
  const std::vector<SignalColumn> columns = signal_columns(fields, signal_names(model));
  const auto column = std::ranges::find(columns, "tip1_travel_mm", &SignalColumn::name);
  ASSERT_NE(column, columns.end());
  EXPECT_EQ(column->factor, 1e3);
  EXPECT_TRUE(scene_message(model, false, {})["slides"].get<bool>());
  EXPECT_FALSE(scene_message(build_model(scene_of("minimal")), false, {}).contains("slides"));
}

// A hand's fingers begin at its wrist, the world's origin; a slide is a rod behind its fingertip, and nothing else.
TEST(SlidesResults, ARecordingDrawsRodsAndNoPalm) {
  const auto entities = hand_entities(ball(), 0.0)["entities"];
  ASSERT_EQ(entities.size(), 4U);
  EXPECT_EQ(entities[0]["cylinders"].size(), 0U);
  EXPECT_EQ(entities[1]["cylinders"].size(), 1U);
  EXPECT_EQ(entities[1]["spheres"].size(), 1U);
}

TEST(SlidesResults, SummaryAndWarningsTellOfStops) {
  const Model model = ball({"hand.slides[0].range=[-1 mm, 0.1 mm]", "hand.slides[0].force=3 N"});
  State state(model);
  const Recording recording = run_scene(model, state);
  const auto joints = summarize(model, recording)["joints"];
  EXPECT_NEAR(joints["least_margin_m"].get<double>(), 0.0, 1e-15);
  EXPECT_GT(joints["stop_max_N"].get<double>(), 0.1);
  EXPECT_FALSE(joints.contains("least_margin_rad"));
  const std::vector<std::string> all = warnings(model, recording);
  EXPECT_TRUE(std::ranges::any_of(all, [](const std::string& warning) {
    return warning.starts_with("the slide tip1_travel carries load at the end of its range, 0.0001 m, from ") &&
           warning.find(" N at ") != std::string::npos;
  })) << (all.empty() ? "none" : all.front());
}

}  // namespace
}  // namespace thenar::slides_results_test
