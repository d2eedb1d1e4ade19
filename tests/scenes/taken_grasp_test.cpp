// SPDX-License-Identifier: Apache-2.0
// A scene that takes its grasp from another one.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/scene_text.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::taken_grasp_test {
namespace {

constexpr const char* kThree = "hand={model: human5, fingers: [thumb, index, major], joint_viscosity: 0.05 N*m*s}";
constexpr const char* kFive = "hand={model: human5, joint_viscosity: 0.05 N*m*s}";

/// The scene with the posture and the pose that found_carry.yaml asks for, as thenar grasp --out writes it. Another
/// pose than the finder's serves as well: taking a grasp does not judge it.
std::filesystem::path grasp_file() {
  Scene scene = scene_of("found_carry", {kThree});
  scene.grasp.reset();
  scene.settles = true;
  for (Eigen::Index i = 0; i < scene.posture.size(); ++i) {
    const Joint& joint = scene.hand.joints[static_cast<std::size_t>(i)];
    scene.posture[i] = 0.7 * joint.lower_rad + 0.3 * joint.upper_rad;
  }
  scene.object.X_WO = Eigen::Translation3d(0.12, 0.05, 0.03) * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY());
  scene.control->internal_force_N = 1.7;
  SceneTextNotes notes;
  notes.hand = config_file("hands/human5");
  notes.names_fingers = true;
  const std::filesystem::path file = scratch() / "grasp-1.yaml";
  write_file(file, scene_text(scene, notes));
  return file;
}

std::string from(const std::filesystem::path& file) { return "grasp={from: " + file.string() + "}"; }

std::string fault_with(const std::vector<std::string>& changes) {
  try {
    (void)scene_of("found_carry", changes);
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.diagnostics().size(), 1U) << error.what();
    return error.diagnostics()[0].key + ": " + error.diagnostics()[0].message;
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

// Fingers, posture, pose and squeeze are the file's, all else the scene's own.
TEST(TakenGrasp, KeepsTheGraspWhileOtherKeysChange) {
  const std::filesystem::path file = grasp_file();
  const Scene grasp = load_scene(file);
  const Scene scene = scene_of("found_carry", {from(file), kFive, "contact.friction=0.5", "object.mass=90 g"});
  EXPECT_FALSE(scene.grasp) << "nothing is to be found";
  EXPECT_EQ(scene.hand.fingers(), 3) << "of five, those that hold";
  EXPECT_EQ(scene.posture, grasp.posture);
  EXPECT_EQ(scene.object.X_WO.matrix(), grasp.object.X_WO.matrix());
  EXPECT_TRUE(scene.settles);
  EXPECT_EQ(scene.control->internal_force_N, 1.7);
  EXPECT_EQ(scene.contact.friction, 0.5);
  EXPECT_EQ(scene.object.mass_kg, 0.09);
}

TEST(TakenGrasp, TheScenesOwnSqueezeCounts) {
  const Scene scene = scene_of("found_carry", {from(grasp_file()), kFive, "control.grasp.internal_force=3 N"});
  EXPECT_EQ(scene.control->internal_force_N, 3.0);
}

TEST(TakenGrasp, IsAmongTheFilesOfTheScene) {
  const std::filesystem::path file = grasp_file();
  EXPECT_EQ(scene_files(config_file("found_carry"), {from(file)}).back(), file);
}

TEST(TakenGrasp, SaysWhyAGraspDoesNotFit) {
  EXPECT_NE(fault_with({"grasp={from: missing.yaml}"}).find("missing.yaml"), std::string::npos);
  EXPECT_NE(fault_with({from(config_file("found_carry"))}).find("has no posture: thenar grasp"), std::string::npos);
  EXPECT_NE(fault_with({from(config_file("slides_ball"))}).find("is no hand"), std::string::npos);
  EXPECT_NE(fault_with({from(config_file("box_grasp"))}).find("the grasp of another object, another box"),
            std::string::npos);
  EXPECT_NE(fault_with({from(grasp_file()), kFive, "hand.fingers=[thumb, index, ring]"})
                .find("holds with the major, which hand.fingers leaves out here"),
            std::string::npos);
  const std::filesystem::path file = grasp_file();
  const std::string hands =
      fault_with({from(file), "hand={model: leap, joint_viscosity: 0.05 N*m*s}", "control.muscles=false"});
  EXPECT_NE(hands.find("has the grasp of another hand"), std::string::npos) << hands;
  EXPECT_NE(fault_with({from(file), kFive, "hand.mirror=true"}).find("hand.mirror differs"), std::string::npos);
  EXPECT_EQ(fault_with({from(file), kFive, "grasp.press=1 N"}), "grasp.press: has no effect here: leave it out");
}

// A file that takes its own grasp would go on for ever.
TEST(TakenGrasp, MustBeInTheFileItself) {
  const std::filesystem::path file = scratch() / "self.yaml";
  std::string text = read_file(config_file("found_carry"));
  const std::size_t begin = text.find("grasp:"), end = text.find("hand:");
  text.replace(begin, end - begin, "grasp: {from: self.yaml}\n");
  write_file(file, text);
  EXPECT_THROW((void)load_scene(file), ConfigError);
}

}  // namespace
}  // namespace thenar::taken_grasp_test
