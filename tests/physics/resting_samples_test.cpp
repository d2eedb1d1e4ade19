// SPDX-License-Identifier: Apache-2.0
// Objects that samples stand for rest where exact ones do.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "collision/solids/sampled_solid.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"

namespace thenar::resting_samples_test {
namespace {

using Eigen::Vector3d;

struct Rest {
  explicit Rest(const Scene& scene) : model(build_model(scene)), state(model), run(run_scene(model, state)) {}

  Model model;
  State state;
  Recording run;
};

/// configs/resting_box.yaml with another object, for so long.
Scene resting(const std::string& shape, const std::string& time, const std::vector<std::string>& more = {}) {
  std::vector<std::string> changes{"time.duration=" + time, "object.shape={" + shape + "}"};
  changes.insert(changes.end(), more.begin(), more.end());
  return scene_of("resting_box", changes);
}

/// The box of that scene as a mesh, in millimetres.
std::filesystem::path box_mesh() {
  const std::filesystem::path file = std::filesystem::path(THENAR_TEST_OUTPUT) / "resting_samples_box.obj";
  std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file);
  for (int i = 0; i < 8; ++i)
    out << "v " << ((i & 1) != 0 ? 30 : -30) << " " << ((i & 2) != 0 ? 30 : -30) << " " << ((i & 4) != 0 ? 30 : -30)
        << "\n";
  for (const char* face : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"})
    out << "f " << face << "\n";
  return file;
}

const std::vector<std::string> kOnATable{
    "environment={friction: 0.3, bodies: [{shape: {plane: true}, position: [300 mm, 0 mm, 0 mm]}]}",
    "object.position=[300 mm, 0 mm, 30.0001 mm]", "object.rotation=[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"};

// Of samples that are up to 14 um over the table, the nearest one lies on the ball that its neighbours make.
TEST(RestingSamples, ABallIsAsHighAsTheExactOne) {
  const Rest exact(resting("sphere: 30 mm", "0.5 s", kOnATable));
  const Rest samples(resting("ellipsoid: [60 mm, 60 mm, 60 mm]", "0.5 s", kOnATable));
  ASSERT_TRUE(samples.model.sampled);
  EXPECT_FALSE(exact.model.sampled);
  EXPECT_NEAR(exact.state.X_WO.translation().z(), 30e-3 - 1e-7 * 0.980665, 1e-12);  // c m g
  EXPECT_NEAR(samples.state.X_WO.translation().z(), exact.state.X_WO.translation().z(), 1e-9);
}

// The corners that no sample has are those of the box: with its mass aside it leans as the box does, by nanometres that
// the corners give way. Nothing creeps: 1 nm/s would be 9 nm in 9 s.
TEST(RestingSamples, AMeshOfABoxRestsAsTheBox) {
  const std::vector<std::string> aside{"object.centre_of_mass=[12 mm, 5 mm, 0 mm]"};
  const Rest exact(resting("box: [60 mm, 60 mm, 60 mm]", "1 s", aside));
  const Rest mesh(resting("cloud: {file: " + box_mesh().string() + ", unit: mm}", "10 s", aside));
  ASSERT_TRUE(mesh.model.sampled);
  const TickRecord &early = mesh.run.ticks[999], &last = mesh.run.ticks.back();
  EXPECT_LE((early.position_m - exact.run.ticks.back().position_m).norm(), 1e-10);
  EXPECT_GT(early.rotation_error_rad, 1e-7);
  EXPECT_NEAR(early.rotation_error_rad, exact.run.ticks.back().rotation_error_rad, 1e-9);
  EXPECT_EQ(last.contact.environment.active, 4);
  EXPECT_LE((last.position_m - early.position_m).norm(), 9e-9);
  EXPECT_LE(52e-3 * std::abs(last.rotation_error_rad - early.rotation_error_rad), 9e-9);
}

// It stands on its rim, of which some points bear, the same ones from tick to tick.
TEST(RestingSamples, AMugOnASlopeDoesNotCreep) {
  const Rest mug(resting("mug: {radius: 30 mm, height: 60 mm, wall: 3 mm}", "10 s"));
  const TickRecord &early = mug.run.ticks[999], &last = mug.run.ticks.back();
  EXPECT_LE((last.position_m - early.position_m).norm(), 9e-9);
  EXPECT_LE(52e-3 * std::abs(last.rotation_error_rad - early.rotation_error_rad), 9e-9);
  EXPECT_LE(last.ledger.injected_J, 1e-9);
  EXPECT_LE(std::abs(last.ledger.unbalanced_J()), 1e-9);
  EXPECT_EQ(mug.run.verdict.outcome, Outcome::kResting) << in_words(mug.run.verdict);
  EXPECT_LE(last.contact.environment.contacts, 40);
}

}  // namespace
}  // namespace thenar::resting_samples_test
