// SPDX-License-Identifier: Apache-2.0
// What NumPy and a parser of OpenSim's storages make of the files is tested with them, in tests/app/export_test.cpp.

#include "engine/recordings/run_tables.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/formats/files.h"
#include "engine/formats/mcap_file.h"
#include "engine/models/build_model.h"
#include "engine/recordings/recording_file.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::run_tables_test {
namespace {

/// A run of some ticks, and what was recorded of it.
struct Recorded {
  explicit Recorded(const RecordingSettings& settings, bool lockstep = false)
      : model(build_model(scene_of("box_grasp", {kCoarseBox, "time.duration=0.12 s"}))), file(scratch() / "run.mcap") {
    RecordingFile film(file, model, settings);
    State state(model);
    RunSettings how{.watchers = {&film}};
    if (lockstep) how.lockstep = LockstepSettings{};
    run = run_scene(model, state, how);
    film.finish(run);
    EXPECT_EQ(film.missing(), "");
  }

  Model model;
  std::filesystem::path file;
  Recording run;
};

TEST(RecordedRun, HasAsManyStatesAsAreAskedFor) {
  for (const auto& [rate_Hz, states] : {std::pair{50.0, 6}, {200.0, 24}, {1000.0, 120}}) {
    const Recorded recorded({.rate_Hz = rate_Hz});
    const RecordedRun run = read_recording(recorded.file);
    EXPECT_TRUE(run.reading.whole);
    EXPECT_EQ(run.name, recorded.model.scene.name);
    ASSERT_EQ(run.states().rows(), states);
    for (Eigen::Index i = 0; i < states; ++i) {
      EXPECT_NEAR(run.times_s()[i], static_cast<double>(i + 1) / rate_Hz, 1e-12);
      const TickRecord& tick = recorded.run.ticks[static_cast<std::size_t>(std::lround(1e3 * run.times_s()[i])) - 1];
      EXPECT_EQ(run.field("q_rad").row(i).transpose(), Eigen::VectorXd(tick.q_rad));
      EXPECT_EQ(run.field("position_m").row(i).transpose(), tick.position_m);
    }
  }
}

TEST(RecordedRun, HasTheFieldsThatAreAskedFor) {
  // Each is read before the next one takes its place.
  const RecordedRun whole = read_recording(Recorded({}).file);
  const Recorded some({.fields = {"q_rad", "force_N", "contacts"}});
  const RecordedRun part = read_recording(some.file);
  ASSERT_EQ(part.fields.size(), 5U);  // Time and tick are always there.
  for (const Field& field : part.fields) EXPECT_EQ(part.field(field.name), whole.field(field.name)) << field.name;
  EXPECT_EQ(part.contacts(), whole.contacts());
  EXPECT_GT(part.contacts().rows(), 6 * 10);
  EXPECT_EQ(read_recording(Recorded({.fields = {"q_rad"}}).file).contacts().rows(), 0);
}

// What a file says of its states and contacts is not to be trusted.
TEST(RecordedRun, IsReadWhateverTheSceneSaysOfRows) {
  const std::filesystem::path file = scratch() / "odd.mcap";
  const nlohmann::ordered_json time = {{"name", "time_s"}, {"unit", "s"}, {"begin", 0U}, {"count", 1U}};
  nlohmann::ordered_json nothing = time;
  nothing["name"] = "nothing";
  nothing["count"] = 0U;
  McapWriter odd(file, {{"/scene", "json", "S", "jsonschema", "{}"}, {"/state", "thenar", "T", "text", ""}});
  odd.add(0, 0.0, nlohmann::ordered_json{{"fields", {time}}, {"contact_fields", {nothing}}}.dump());
  odd.add(1, 0.0, "THNR" + std::string("\x01\x00\x02\x00", 4) + std::string(32, '\0'));
  odd.finish();
  const RecordedRun run = read_recording(file);
  EXPECT_EQ(run.states().rows(), 1);
  EXPECT_EQ(run.contacts().rows(), 0);
}

nlohmann::ordered_json field_json(const std::string& name, std::size_t begin, std::size_t count) {
  return {{"name", name}, {"unit", "m"}, {"begin", begin}, {"count", count}};
}

/// A state message without contacts.
std::string state_bytes(const std::vector<double>& numbers) {
  return "THNR" + std::string("\x01\x00\x02\x00", 4) +
         std::string(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double));
}

/// What is said of a recording of these scenes, each followed by so many states.
std::string fault_of(const std::vector<nlohmann::ordered_json>& scenes, const std::vector<double>& state = {1.0},
                     int states = 1) {
  const std::filesystem::path file = scratch() / "odd.mcap";
  McapWriter odd(file, {{"/scene", "json", "S", "jsonschema", "{}"}, {"/state", "thenar", "T", "text", ""}});
  for (const nlohmann::ordered_json& scene : scenes) {
    odd.add(0, 0.0, scene.dump());
    if (&scene == &scenes.back()) {
      for (int i = 0; i < states; ++i) odd.add(1, 0.0, state_bytes(state));
    }
  }
  odd.finish();
  try {
    const RecordedRun run = read_recording(file);
    EXPECT_EQ(run.states().rows(), states);
    return "";
  } catch (const FileError& error) {
    return std::string(error.what()).substr(file.string().size() + 2);
  }
}

nlohmann::ordered_json scene_json(const std::vector<nlohmann::ordered_json>& fields) { return {{"fields", fields}}; }

// A number of a state belongs to one field: else a short state has any number of columns.
TEST(RecordedRun, FieldsLieOneBehindTheOther) {
  const std::string other = "has states of another version";
  EXPECT_EQ(fault_of({scene_json({field_json("time_s", 0, 1)})}), "");
  EXPECT_EQ(fault_of({scene_json({field_json("time_s", 0, 1), field_json("a", 0, 1)})}), other) << "overlap";
  EXPECT_EQ(fault_of({scene_json({field_json("time_s", 0, 1), field_json("a", 2, 1)})}, {1, 2, 3}), other) << "gap";
  EXPECT_EQ(fault_of({scene_json({field_json("time_s", 0, 1), field_json("a", 1, 1'000'000)})}), other);
}

// A scene without the first one's fields: rows of NaN, as many as the file is worth.
TEST(RecordedRun, TakesMemoryInProportionToItsStates) {
  const auto first = scene_json({field_json("time_s", 0, 1), field_json("x", 1, 50'000)});
  const auto none = scene_json(nlohmann::ordered_json::array());
  EXPECT_EQ(fault_of({first, none}, {}, 3), "");
  EXPECT_EQ(fault_of({first, none}, {}, 2000), "has states of another version");
}

// Many fields and many states: each name is looked up once a scene.
TEST(RecordedRun, LooksUpNamesOnceAScene) {
  std::vector<nlohmann::ordered_json> fields{field_json("time_s", 0, 1)};
  for (int i = 0; i < 20'000; ++i) fields.push_back(field_json("f" + std::to_string(i), 1, 0));
  EXPECT_EQ(fault_of({scene_json(fields)}, {1.0}, 3000), "");
}

// They become names of files in an archive, and heads of columns in a spreadsheet.
TEST(RecordedRun, NamesAreWords) {
  for (const std::string name : {"", "../a", "a b", "=1+1", "a\nb", "time_s", "a-b"}) {
    const std::string fault = fault_of({scene_json({field_json("time_s", 0, 1), field_json(name, 1, 1)})}, {1, 2});
    EXPECT_NE(fault.find("names a part '"), std::string::npos) << name << ": " << fault;
  }
  for (const std::string name : {"thumb", "=cmd()", "a\nb", "@x"}) {
    nlohmann::ordered_json scene = scene_json({field_json("time_s", 0, 1)});
    scene["fingers"] = {{{"name", name}}};
    EXPECT_EQ(fault_of({scene}).empty(), name == "thumb") << name;
    scene["fingers"] = {{{"name", "thumb"}}, {{"name", "thumb"}}};
    EXPECT_NE(fault_of({scene}), "") << "two columns of one name";
  }
}

TEST(RecordedRun, NamesFieldsThatAreThere) {
  const Model model = build_model(scene_of("minimal"));
  EXPECT_EQ(unknown_field(model, {"q_rad", "time_s"}), "");
  EXPECT_NE(unknown_field(model, {"q_rad", "q_radd"}).find("'q_radd', did you mean 'q_rad'?"), std::string::npos);
}

// The contacts of a tick add up to what the fingers carry, in every tick, whoever runs it.
TEST(RecordedRun, HasEveryContactInEveryTick) {
  for (const bool lockstep : {false, true}) {
    const Recorded recorded({.contacts = true}, lockstep);
    const RecordedRun run = read_recording(recorded.file);
    std::size_t tick = 0;
    for (const ContactBlock& block : run.contact_blocks) {
      EXPECT_NEAR(block.time_s, recorded.run.ticks[tick].time_s, 1e-12);
      EXPECT_EQ(block.step_s, recorded.model.scene.step_s);
      for (std::uint32_t i = 0; i < block.ticks; ++i, ++tick) {
        ASSERT_LT(tick, recorded.run.ticks.size());
        ASSERT_EQ(recorded.run.ticks[tick].contact.contacts, block.contacts);
        double normal_N = 0.0, expected_N = 0.0;
        for (std::uint32_t c = 0; c < block.contacts; ++c) normal_N += block.rows[i * block.contacts + c].force_N[0];
        for (const NormalTangential& force : recorded.run.ticks[tick].force) expected_N += force.normal_N;
        // That of the fingers is along their mean normals: on the flat faces of a box these are the contacts' own, but
        // for what the surface of samples is not flat.
        EXPECT_NEAR(normal_N, expected_N, 1e-3 * (1.0 + expected_N));
      }
    }
    EXPECT_EQ(tick, recorded.run.ticks.size());
  }
}

TEST(RunTables, AStorageHasAnglesAndForcesByName) {
  const Recorded recorded({});
  const RecordedRun run = read_recording(recorded.file);
  std::istringstream sto(run_sto(run, recorded.file));
  std::string line;
  std::getline(sto, line);
  EXPECT_EQ(line, recorded.model.scene.name);
  std::vector<std::string> head;
  while (std::getline(sto, line) && line != "endheader") head.push_back(line);
  EXPECT_EQ(head[0], "version=1");
  EXPECT_EQ(head[1], "nRows=6");
  EXPECT_EQ(head[2], "nColumns=36");  // Time, 12 joints, 23 muscles.
  EXPECT_EQ(head[3], "inDegrees=no");
  std::getline(sto, line);
  std::istringstream names(line);
  std::vector<std::string> columns;
  for (std::string name; std::getline(names, name, '\t');) columns.push_back(name);
  ASSERT_EQ(columns.size(), 36U);
  EXPECT_EQ(columns[0], "time");
  EXPECT_EQ(columns[1], recorded.model.scene.hand.joints[0].name);
  EXPECT_EQ(columns[13], recorded.model.scene.hand.muscles[0].name);
  for (Eigen::Index row = 0; row < 6; ++row) {
    std::getline(sto, line);
    std::istringstream numbers(line);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      double number = NAN;
      numbers >> number;
      const Eigen::Index at = static_cast<Eigen::Index>(i);
      const double expected = i == 0   ? run.times_s()[row]
                              : i < 13 ? run.field("q_rad")(row, at - 1)
                                       : run.field("muscles_N")(row, at - 13);
      EXPECT_EQ(number, expected) << columns[i];  // The digits read back the same.
    }
  }
}

TEST(RunTables, AStorageOfNothingIsRefused) {
  const Recorded recorded({.fields = {"force_N"}});
  EXPECT_THROW((void)run_sto(read_recording(recorded.file), recorded.file), FileError);
}

}  // namespace
}  // namespace thenar::run_tables_test
