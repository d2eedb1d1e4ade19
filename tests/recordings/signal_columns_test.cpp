// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/signal_columns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/formats/mcap_file.h"
#include "engine/models/build_model.h"
#include "engine/recordings/recording_file.h"
#include "engine/recordings/run_tables.h"
#include "engine/recordings/signals.h"
#include "engine/results/scene_run.h"
#include "tests/support/messages.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::signal_columns_test {
namespace {

using nlohmann::ordered_json;

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> all;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) all.push_back(cell);
  return all;
}

// One vocabulary: what signals.csv says of a tick, a recording's table and its JSON say by the same names.
void expect_the_words_of_signals(const std::string& scene) {
  const Model model = build_model(scene_of(scene, {kCoarseBox, "time.duration=0.1 s"}));
  const std::filesystem::path file = scratch() / (scene + ".mcap");
  RecordingFile film(file, model);
  State state(model);
  const Recording run = run_scene(model, state, {.lockstep = LockstepSettings{}, .watchers = {&film}});
  film.finish(run);
  std::istringstream signals(signals_csv(model, run)), table(run_csv(read_recording(file)));
  std::string line, last_tick, last_state;
  std::getline(signals, line);
  const std::vector<std::string> words = cells(line);
  std::getline(table, line);
  const std::vector<std::string> columns = cells(line);
  while (std::getline(signals, line)) last_tick = line;
  while (std::getline(table, line)) last_state = line;
  ordered_json json;
  for (const KeptMessage& message : messages_in(file).messages) {
    if (message.topic == "/signals") json = ordered_json::parse(message.bytes);
  }
  const std::vector<std::string> ticks = cells(last_tick), states = cells(last_state);
  for (std::size_t i = 0; i < words.size(); ++i) {
    SCOPED_TRACE(words[i]);
    const auto column = std::find(columns.begin(), columns.end(), words[i]);
    ASSERT_NE(column, columns.end());
    const double value = std::stod(ticks[i]);
    // signals.csv has nine digits.
    const double shown = std::stod(states[static_cast<std::size_t>(column - columns.begin())]);
    if (!std::isnan(value)) {
      EXPECT_NEAR(shown, value, 1e-8 * std::abs(value));
      EXPECT_EQ(json.at(words[i]).get<double>(), shown);
    }
  }
}

TEST(RecordingFile, SpeaksTheWordsOfSignals) {
  expect_the_words_of_signals("box_grasp");
  expect_the_words_of_signals("resting_box");
}

// Before 0.8 fields had other names, and joints none.
TEST(RecordingFile, OldOnesAreReadInTheSameWords) {
  const ordered_json scene = {{"fields",
                               {{{"name", "force_n_N"}, {"unit", "N"}, {"begin", 0U}, {"count", 2U}},
                                {{"name", "q_rad"}, {"unit", "rad"}, {"begin", 2U}, {"count", 1U}},
                                {{"name", "penetration_m"}, {"unit", "m"}, {"begin", 3U}, {"count", 1U}}}},
                              {"fingers", {{{"name", "thumb"}}, {{"name", "index"}}}}};
  const std::array<double, 4> numbers = {1.5, 2.5, 0.25, 3e-6};
  std::string state = "THNR" + std::string("\x01\x00\x02\x00", 4);
  state.append(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
  const std::filesystem::path file = scratch() / "old.mcap";
  McapWriter old(file, {{"/scene", "json", "S", "jsonschema", "{}"}, {"/state", "thenar", "T", "text", ""}});
  old.add(0, 0.0, scene.dump());
  old.add(1, 0.0, state);
  old.finish();
  EXPECT_EQ(run_csv(read_recording(file)), "thumb_normal_N,index_normal_N,q_rad,penetration_um\n1.5,2.5,0.25,3\n");
}

// Before version 3 the forces of muscles with stiffness lacked what their stretch adds, and do not pass for all of it.
TEST(RecordingFile, OldForcesOfStretchedMusclesAreReadAsWhatTheyWere) {
  for (const bool stiff : {false, true}) {
    ordered_json scene = {{"version", 2},
                          {"fields",
                           {{{"name", "time_s"}, {"unit", "s"}, {"begin", 0U}, {"count", 1U}},
                            {{"name", "q_rad"}, {"unit", "rad"}, {"begin", 1U}, {"count", 1U}},
                            {{"name", "muscles_N"}, {"unit", "N"}, {"begin", 2U}, {"count", 1U}}}},
                          {"muscles", {{{"name", "FPL"}}}}};
    if (stiff) scene["object_stiffness"] = nullptr;
    const std::array<double, 3> numbers = {0.5, 0.25, 8.5};
    std::string state = "THNR" + std::string("\x02\x00\x02\x00", 4);
    state.append(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
    const std::filesystem::path file = scratch() / "old_forces.mcap";
    McapWriter old(file, {{"/scene", "json", "S", "jsonschema", "{}"}, {"/state", "thenar", "T", "text", ""}});
    old.add(0, 0.0, scene.dump());
    old.add(1, 0.5, state);
    old.finish();
    const RecordedRun run = read_recording(file);
    EXPECT_EQ(run_csv(run), std::string("time_s,q_rad,FPL_") + (stiff ? "unstretched_N" : "N") + "\n0.5,0.25,8.5\n");
    EXPECT_TRUE(run_sto(run, file).ends_with("time\tjoint_1\tFPL\n0.5\t0.25\t8.5\n"));
  }
}

}  // namespace
}  // namespace thenar::signal_columns_test
