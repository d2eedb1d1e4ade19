// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/recording_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "engine/formats/files.h"
#include "engine/models/build_model.h"
#include "engine/recordings/run_tables.h"
#include "engine/results/recorder.h"
#include "engine/results/scene_run.h"
#include "tests/support/messages.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"
#include "tests/support/three_fingers.h"

namespace thenar::recording_file_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

std::map<std::string, Field> by_name(const std::vector<Field>& fields) {
  std::map<std::string, Field> names;
  for (const Field& field : fields) names[field.name] = field;
  return names;
}

/// A grasp that is recorded.
struct Film {
  explicit Film(Scene scene)
      : model(build_model(std::move(scene))),
        loops(model, LockstepSettings{}),
        file(scratch() / "film.mcap"),
        film(file, model) {}

  /// One tick; the state after it if it is kept.
  std::optional<State> tick() {
    const TickReport contact = loops.tick();
    TickRecord record = tick_record(model, loops.state, contact, loops.report);
    film.add(loops.state, loops.memory, loops.work, record, loops.controller.f_muscle);
    if (!film.is_due(loops.state.tick)) return std::nullopt;
    return loops.state;
  }

  Model model;
  GraspRun loops;
  std::filesystem::path file;
  RecordingFile film;
};

// A minute, bit by bit: what is replayed is what was simulated, not something near it.
TEST(RecordingFile, OfAMinuteHoldsTheStatesBitByBit) {
  Film grasp(scene_of("box_grasp", {"time.control_period=5 ms", kCoarseBox}));
  std::vector<State> kept;
  while (grasp.loops.state.tick < 60'000) {
    if (const auto state = grasp.tick()) kept.push_back(*state);
  }
  grasp.film.finish();
  ASSERT_EQ(kept.size(), 3000U);  // 50 a second

  const KeptMessages contents = messages_in(grasp.file);
  EXPECT_TRUE(contents.reading.whole);
  auto fields = by_name(state_fields(grasp.model));
  auto state = kept.begin();
  for (const KeptMessage& message : contents.messages) {
    if (message.topic != "/state") continue;
    ASSERT_NE(state, kept.end());
    const std::vector<double> numbers = read_state_message(message.bytes);
    const auto at = [&](const char* name) { return numbers.data() + fields.at(name).begin; };
    ASSERT_EQ(*at("tick"), static_cast<double>(state->tick));
    ASSERT_EQ(std::memcmp(at("q_rad"), state->q.data(), sizeof(double) * state->q.size()), 0);
    ASSERT_EQ(std::memcmp(at("object"), state->X_WO.translation().data(), 3 * sizeof(double)), 0);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        ASSERT_EQ(at("object")[3 + 3 * row + column], state->X_WO.linear()(row, column));
      }
    }
    const double* u = at("displacement_m");
    for (const Eigen::MatrixX3d& u_m : state->u_m) {
      for (Index i = 0; i < u_m.rows(); ++i, u += 3) ASSERT_EQ(Vector3d(u[0], u[1], u[2]), Vector3d(u_m.row(i)));
    }
    ++state;
  }
  EXPECT_EQ(state, kept.end());
}

// A finger's contacts add up to its load: what is drawn as arrows is what acts.
TEST(RecordingFile, ShowsContactsThatAddUpToTheFingersLoads) {
  Film grasp(scene_of("box_grasp", {kCoarseBox}));
  Picture picture(grasp.model);
  while (grasp.loops.state.tick < 300) {
    grasp.tick();
    take_picture(grasp.loops.state, grasp.loops.memory, grasp.loops.work, picture);
    ASSERT_EQ(std::ssize(picture.contacts), grasp.loops.frame.size());
    for (int k = 0; k < kFingers; ++k) {
      Vector3d sum = Vector3d::Zero();
      for (const ShownContact& contact : picture.contacts) {
        EXPECT_NEAR(contact.normal.norm(), 1.0, 1e-12);
        if (contact.finger == k) sum += contact.force_N;
      }
      // Sums of 20 products in another order.
      const Vector3d& load = grasp.loops.state.load[k].force_N;
      EXPECT_LE((sum - load).norm(), 1e-14 * (1.0 + load.norm()));
    }
  }
  ASSERT_GT(grasp.loops.state.load[0].normal_N, 1.0);
}

// The values that are told by name read back as they were.
TEST(RecordingFile, IsExportedAsColumns) {
  Film grasp(scene_of("box_grasp", {kCoarseBox}));
  std::vector<State> kept;
  while (grasp.loops.state.tick < 200) {
    if (const auto state = grasp.tick()) kept.push_back(*state);
  }
  grasp.film.finish();
  std::istringstream csv(run_csv(read_recording(grasp.file)));
  std::string line;
  std::getline(csv, line);
  const auto columns = std::count(line.begin(), line.end(), ',');
  const std::string before = line.substr(0, line.find(grasp.model.scene.hand.joints[0].name + "_rad"));
  const auto column = std::count(before.begin(), before.end(), ',');
  for (const State& state : kept) {
    ASSERT_TRUE(std::getline(csv, line));
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns);
    std::size_t begin = 0;
    for (std::ptrdiff_t i = 0; i < column; ++i) begin = line.find(',', begin) + 1;
    EXPECT_EQ(std::stod(line.substr(begin)), state.q[0]);
  }
  EXPECT_FALSE(std::getline(csv, line));
}

// Slips are sums that the run keeps: they must have come into what is recorded of each tick.
TEST(RecordingFile, KnowsTheSlipsOfARun) {
  const Model model = build_model(scene_of("slide", {"time.duration=0.6 s"}));
  const std::filesystem::path file = scratch() / "slide.mcap";
  RecordingFile film(file, model);
  State state(model);
  const Recording run = run_scene(model, state, {.lockstep = LockstepSettings{}, .watchers = {&film}});
  film.finish(run);
  const Field slip = by_name(state_fields(model)).at("slip_m");
  std::vector<double> last;
  for (const KeptMessage& message : messages_in(file).messages) {
    if (message.topic == "/state") last = read_state_message(message.bytes);
  }
  ASSERT_FALSE(last.empty());
  EXPECT_GT(run.ticks.back().slip_m[0], 1e-4);
  EXPECT_EQ(last[slip.begin], run.ticks.back().slip_m[0]);
}

TEST(RecordingFile, RefusesAFileWithoutAScene) {
  const std::filesystem::path file = scratch() / "a.mcap";
  McapWriter(file, {{"/scene", "json", "S", "jsonschema", "{}"}}).add(0, 0.0, "{}");
  EXPECT_THROW((void)read_recording(file), FileError);
  McapWriter(file, {{"/other", "json", "S", "jsonschema", "{}"}}).finish();
  EXPECT_THROW((void)read_recording(file), FileError);
}

}  // namespace
}  // namespace thenar::recording_file_test
