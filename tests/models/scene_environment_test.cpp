// SPDX-License-Identifier: Apache-2.0
#include "engine/models/scene_environment.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <variant>

#include "engine/formats/files.h"
#include "engine/scenes/scene_file.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::scene_environment_test {
namespace {

using Eigen::Vector3d;

Environment with_bodies(const std::string& bodies, const std::string& more = "friction: 0.3, ") {
  return *scene_of("resting_box", {"environment={" + more + "bodies: [" + bodies + "]}"}).environment;
}

TEST(SceneEnvironment, ReadsBodiesWithTheirFriction) {
  const Environment environment = with_bodies(
      "{shape: {box: [10 mm, 20 mm, 30 mm]}, position: [1 mm, 2 mm, 3 mm]},"
      "{name: post, shape: {cylinder: {radius: 4 mm, length: 50 mm}}, position: [0 mm, 0 mm, 0 mm], friction: 0.7,"
      " move: [{by: [0 mm, 0 mm, 5 mm], from: 1 s, over: 2 s}]},"
      "{shape: {hole: {diameter: 20 mm, depth: 30 mm}}, position: [0 mm, 0 mm, 0 mm]}");
  ASSERT_EQ(environment.bodies.size(), 3U);
  EXPECT_EQ(environment.compliance_m_per_N, 1e-7) << "unless it says otherwise";
  EXPECT_EQ(environment.bodies[0].name, "1");
  EXPECT_EQ(environment.bodies[0].friction, 0.3);
  EXPECT_EQ(std::get<BoxShape>(environment.bodies[0].shape).size_m, Vector3d(10e-3, 20e-3, 30e-3));
  EXPECT_EQ(environment.bodies[0].X_WE.translation(), Vector3d(1e-3, 2e-3, 3e-3));
  EXPECT_EQ(environment.bodies[1].name, "post");
  EXPECT_EQ(environment.bodies[1].friction, 0.7);
  ASSERT_EQ(environment.bodies[1].moves.size(), 1U);
  EXPECT_EQ(environment.bodies[1].moves[0].over_s, 2.0);
  EXPECT_EQ(std::get<HoleShape>(environment.bodies[2].shape).radius_m, 10e-3);
  EXPECT_EQ(std::get<HoleShape>(environment.bodies[2].shape).chamfer_m, 0.0);
}

/// What is wrong with resting_box.yaml when a part of its text is another.
std::string fault_of(const std::string& part, const std::string& other) {
  std::string text = read_file(config_file("resting_box"));
  const std::size_t at = text.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  text.replace(at, part.size(), other);
  const std::filesystem::path file = scratch() / "scene.yaml";
  write_file(file, text);
  try {
    (void)load_scene(file);
  } catch (const ConfigError& error) {
    const std::string fault = error.what(), begin = file.string() + ":";
    EXPECT_TRUE(fault.starts_with(begin)) << fault;
    return fault.substr(begin.size());
  }
  return "";
}

// One fault is told once: where it is, at which key, and what would do.
TEST(SceneEnvironment, TellsWhatIsWrongAndWhere) {
  EXPECT_EQ(fault_of("friction: 0.3\n", "compliance: 1 um/N\n"),
            "24:7: environment.bodies[0].friction: is needed here, or in environment");
  EXPECT_EQ(fault_of("{plane: true}", "{hole: {diameter: 20 mm, depth: 5 mm, chamfer: 5 mm}}"),
            "24:75: environment.bodies[0].shape.hole.chamfer: must be less than the depth");
  EXPECT_EQ(fault_of("{plane: true}", "{plane: false}"),
            "24:36: environment.bodies[0].shape.plane: is true, or is left out");
  EXPECT_EQ(fault_of("{plane: true}", "{cube: 3 mm}").substr(0, 5), "24:29");
}

}  // namespace
}  // namespace thenar::scene_environment_test
