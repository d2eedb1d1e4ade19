// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "engine/formats/files.h"
#include "engine/models/build_model.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/scene_text.h"
#include "tests/support/scratch.h"

namespace thenar::scene_slides_test {
namespace {

using Eigen::Vector3d;

/// A ball under slides that are written here.
Scene scene_with(const std::string& slides, const std::string& hand = "", const std::string& more = "") {
  const std::filesystem::path file = scratch() / "scene.yaml";
  write_file(file, "name: slides\ntime: {duration: 1 s, step: 1 ms, control_period: 1 ms}\nhand:\n" + hand +
                       "  slides: [" + slides +
                       "]\n"
                       "object:\n  shape: {sphere: 25 mm}\n  points: 2000\n  mass: 100 g\n"
                       "  position: [0 mm, 0 mm, 0 mm]\n  rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
                       "  damping: {translation: 10 N*s/m, rotation: 0.005 N*m*s}\n"
                       "contact: {friction: 0.5, band: 0.3 mm}\n" +
                       more);
  return load_scene(file);
}

const std::string kPlace = "at: [0 mm, 0 mm, 33 mm], along: [0, 0, -2], radius: 8 mm";

/// The one fault, from its line on.
std::string fault_of(const std::string& slides, const std::string& hand = "", const std::string& more = "") {
  try {
    (void)scene_with(slides, hand, more);
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.diagnostics().size(), 1U) << error.what();
    const std::string text = error.what();
    return text.substr(text.find("scene.yaml:") + 11);
  }
  return "";
}

TEST(SceneSlides, AreTheFingersOfAHand) {
  const Scene scene = scene_with(
      "{" + kPlace +
      ", force: -2 N, rise: 0.1 s, damping: 5 N*s/m, range: [-1 mm, 2 mm]}, {name: side, at: [33 mm, 0 "
      "mm, 0 mm], along: [-1, 0, 0], radius: 9 mm, path: [{by: [1 mm, 2 mm, 3 mm], over: 1 s}, {by: [0 mm, 0 mm, -1 "
      "mm], over: 2 s, profile: minimum_jerk}]}, {at: [-33 mm, 0 mm, 0 mm], along: [1, 0, 0], radius: 8 mm, spring: "
      "{stiffness: 500 N/m, rest: 1 mm}}");
  const Hand& hand = scene.hand;
  EXPECT_TRUE(hand.slides);
  ASSERT_EQ(hand.fingers(), 3);
  ASSERT_EQ(hand.joints.size(), 5U);
  EXPECT_EQ(scene.posture, JointVector::Zero(5));
  EXPECT_EQ(hand.fingertips[0].finger, "tip1");
  EXPECT_EQ(hand.fingertips[1].finger, "side");
  EXPECT_EQ(hand.joints[0].name, "tip1_travel");
  EXPECT_EQ(hand.joints[2].name, "side_travel_y");
  EXPECT_EQ(hand.joints[0].axis, Vector3d(0.0, 0.0, -1.0));
  EXPECT_EQ(hand.joints[0].lower_rad, -1e-3);
  EXPECT_EQ(hand.joints[0].upper_rad, 2e-3);
  EXPECT_EQ(scene.viscosity(0), 5.0);
  EXPECT_EQ(scene.viscosity(2), 10.0);
  EXPECT_EQ(scene.slides[0].force_N, -2.0);
  EXPECT_EQ(scene.slides[0].rise_s, 0.1);
  EXPECT_FALSE(scene.has_path(0));
  EXPECT_TRUE(scene.has_path(1));
  EXPECT_EQ(scene.slides[1].path[0].by_m, Vector3d(1e-3, 2e-3, 3e-3));
  EXPECT_FALSE(scene.slides[1].path[0].smooth);
  EXPECT_TRUE(scene.slides[1].path[1].smooth);
  EXPECT_EQ(scene.slides[2].stiffness_N_per_m, 500.0);
  EXPECT_EQ(scene.slides[2].rest_m, 1e-3);
  // Each faces along its slide, and goes there without a turn.
  HandPose pose;
  JointVector q(5);
  q << 1e-3, 2e-3, 3e-3, 4e-3, 5e-3;
  forward_kinematics(hand, q, pose);
  EXPECT_TRUE(pose.distal(hand, 0).translation().isApprox(Vector3d(0.0, 0.0, 32e-3), 1e-15));
  EXPECT_TRUE(pose.distal(hand, 1).translation().isApprox(Vector3d(35e-3, 3e-3, 4e-3), 1e-15));
  EXPECT_TRUE(pose.distal(hand, 2).translation().isApprox(Vector3d(-28e-3, 0.0, 0.0), 1e-15));
  for (int k = 0; k < 3; ++k) {
    const Vector3d faces = pose.distal(hand, k).linear() * hand.fingertips[k].normal;
    const Vector3d there = k == 0 ? Vector3d(0.0, 0.0, -1.0) : Vector3d(k == 1 ? -1.0 : 1.0, 0.0, 0.0);
    EXPECT_TRUE(faces.isApprox(there, 1e-15)) << k;
    EXPECT_TRUE(turning_axes(hand, pose, k).isZero(0.0));
  }
}

TEST(SceneSlides, ReadBackAsTheyAreWritten) {
  const Scene scene = scene_with(
      "{" + kPlace + ", force: -2 N, rise: 0.1 s, damping: 5 N*s/m, range: [-1 mm, 2 mm]}, {name: a b, " + kPlace +
      ", path: [{by: [1 mm, 2 mm, 3 mm], over: 1 s}, {by: [0 mm, 0 mm, -1 mm], over: 2 s, profile: minimum_jerk}]}, {" +
      kPlace + ", spring: {stiffness: 500 N/m, rest: 1 mm}}");
  const std::filesystem::path file = scratch() / "again.yaml";
  write_file(file, scene_text(scene, {}));
  const Scene again = load_scene(file);
  EXPECT_EQ(scene_text(again, {}), scene_text(scene, {}));
  EXPECT_EQ(again.hand.fingertips[1].finger, "a b");
  EXPECT_EQ(again.slides[1].path.size(), 2U);
}

// One fault is told once: where it is, at which key, and what would do.
TEST(SceneSlides, TellWhatIsWrongAndWhere) {
  const std::string drive = "{" + kPlace + ", force: 1 N", slide = drive + "}";
  EXPECT_EQ(fault_of(slide), "");
  EXPECT_EQ(fault_of("{" + kPlace + "}"),
            "4:12: hand.slides[0].force: is missing: a slide has a force, a spring or a path");
  EXPECT_EQ(fault_of(drive + ", spring: {stiffness: 1 N/m, rest: 0 mm}}"),
            "4:91: hand.slides[0].spring: a slide has one of force, spring and path, and force is there: leave out all "
            "but one");
  EXPECT_EQ(fault_of("{" + kPlace + ", rise: 1 s, spring: {stiffness: 1 N/m, rest: 0 mm}}"),
            "4:77: hand.slides[0].rise: is of a force, and there is none: leave it out");
  EXPECT_EQ(fault_of("{at: [0 mm, 0 mm, 0 mm], along: [0, 0, 0], radius: 8 mm, force: 1 N}"),
            "4:44: hand.slides[0].along: a direction must not be zero");
  EXPECT_EQ(fault_of("{" + kPlace + ", path: []}"), "4:77: hand.slides[0].path: names no leg");
  EXPECT_EQ(
      fault_of("{" + kPlace + ", path: [{by: [0.6 m, 0 m, 0 m], over: 1 s}, {by: [0.6 m, 0 m, 0 m], over: 1 s}]}"),
      "4:77: hand.slides[0].path: leads further than 1 m away from its start");
  EXPECT_EQ(fault_of("{" + kPlace + ", path: [{by: [0 m, 0 m, 0 m], over: 1 s}], damping: 1 N*s/m}"),
            "4:122: hand.slides[0].damping: has no effect on a path: leave it out");
  EXPECT_EQ(fault_of(drive + ", range: [1 mm, 2 mm]}"),
            "4:90: hand.slides[0].range: must reach from 0 or less to 0 or more: 0 is where the fingertip is at the "
            "start");
  const std::string twice = fault_of(drive + ", name: a}, " + drive + ", name: a}");
  EXPECT_NE(twice.find(": hand.slides[1].name: is there twice: 'a'"), std::string::npos) << twice;
  EXPECT_EQ(fault_of(slide + ", " + slide + ", " + slide + ", " + slide + ", " + slide + ", " + slide),
            "4:11: hand.slides: must list 1 to 5 fingertips");
  EXPECT_EQ(fault_of(""), "4:11: hand.slides: must list 1 to 5 fingertips");
  EXPECT_EQ(fault_of(drive + ", froce: 1 N}"),
            "4:83: hand.slides[0].froce: unknown key, did you mean 'hand.slides[0].force'?");
}

// What a hand has, slides do not: each is refused by its name.
TEST(SceneSlides, TakeThePlaceOfAHand) {
  const std::string slide = "{" + kPlace + ", force: 1 N}";
  for (const std::string key : {"model: hand.yaml", "posture: [0 rad]", "joint_viscosity: 1 N*m*s", "torques: [1 N*m]",
                                "mirror: true", "fingers: [thumb]", "settle: true"}) {
    EXPECT_EQ(fault_of(slide, "  " + key + "\n"),
              "4:" + std::to_string(key.find(':') + 5) + ": hand." + key.substr(0, key.find(':')) +
                  ": is of a hand, and slides take its place: leave out one of them");
  }
  EXPECT_EQ(fault_of(slide, "", "grasp: auto\n"),
            "13:8: grasp: is of a hand, and hand.slides take its place: leave out one of them");
  EXPECT_EQ(fault_of(slide, "", "control: {law: paper}\n"),
            "13:10: control: is of a hand, and hand.slides take its place: leave out one of them");
  EXPECT_EQ(fault_of(slide, "", "task: {phases: [{close: {press: 1 N, speed: 1 mm/s}}]}\n").substr(0, 15),
            "13:16: task.pha");
}

}  // namespace
}  // namespace thenar::scene_slides_test
