// SPDX-License-Identifier: Apache-2.0
#include "engine/models/scene_grasp.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "engine/control/control_tick.h"
#include "engine/grasp/contact_tick.h"
#include "engine/models/build_model.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::scene_grasp_test {
namespace {

/// The box grasp without the lines that place hand and object.
std::filesystem::path without_places(const std::string& name = "box_grasp") {
  std::ifstream in(config_file(name));
  const std::filesystem::path file = scratch() / "found.yaml";
  std::ofstream out(file);
  bool skips = false;
  for (std::string line; std::getline(in, line);) {
    const std::size_t indent = line.find_first_not_of(' ');
    if (indent != std::string::npos && indent <= 2) {
      skips =
          line.starts_with("  posture: [") || line.starts_with("  position: [") || line.starts_with("  rotation: [");
    }
    if (!skips) out << line << "\n";
  }
  return file;
}

Scene found_scene(const std::vector<std::string>& changes) {
  std::vector<std::string> all{"object.points=6000"};
  all.insert(all.end(), changes.begin(), changes.end());
  return load_scene(without_places(), all);
}

std::string fault_of(const std::vector<std::string>& changes) {
  try {
    (void)build_model(found_scene(changes));
  } catch (const ConfigError& error) {
    return error.diagnostics().front().key + ": " + error.diagnostics().front().message;
  }
  return "";
}

TEST(SceneGrasp, IsFoundWhenTheModelIsMade) {
  const Scene scene = found_scene({"grasp=auto"});
  ASSERT_TRUE(scene.grasp);
  const Model model = build_model(scene), again = build_model(scene);
  EXPECT_FALSE(model.scene.grasp);
  EXPECT_FALSE(model.grasp_notes.empty());
  EXPECT_EQ(model.scene.posture, again.scene.posture) << "the same bits";
  EXPECT_EQ(model.scene.object.X_WO.matrix(), again.scene.object.X_WO.matrix());
  // A model that is made again of its own scene does not search; its fingers settle, and hardly move.
  const Model third = build_model(model.scene, model);
  EXPECT_TRUE(third.grasp_notes.empty());
  EXPECT_LT((third.scene.posture - model.scene.posture).cwiseAbs().maxCoeff(), 1e-3);
}

// The fingers press at the first tick with what the controller asks for, to what settle() leaves, 0.5 %, and the little
// that bodies move in the tick itself.
TEST(SceneGrasp, BeginsWithTheLoadThatTheControllerAsksFor) {
  const Model model = build_model(found_scene({"grasp={press: 1.2 N}", "control.grasp={friction: 0.5}"}));
  State state(model);
  Controller controller(model);
  Frame frame(model);
  ContactMemory memory(model);
  ContactScratch work(model);
  const ControlReport report = control_tick(model, state, controller, frame);
  EXPECT_EQ(report.grasp, GraspStatus::kOptimal);
  (void)contact_tick(model, frame, memory, work, state);
  double least_N = 1e9;
  for (int k = 0; k < model.fingers(); ++k) {
    const FingerLoad& load = state.load[k];
    const double wanted_N = load.normal.dot(report.f_desired.col(k));
    EXPECT_NEAR(load.normal_N, wanted_N, 0.02 * wanted_N) << k;
    least_N = std::min(least_N, load.normal_N);
  }
  // The weight, about 1 N, is shared by friction and changes the loads by less than itself.
  EXPECT_NEAR(least_N, 1.2, 0.6);
}

// Without control the torques that are found balance the fingers: they keep their load for a tenth of a second.
TEST(SceneGrasp, FindsTheTorquesOfASceneWithoutControl) {
  std::ifstream in(without_places());
  const std::filesystem::path file = scratch() / "free.yaml";
  std::ofstream out(file);
  bool control = false;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line.front() != ' ') control = line.starts_with("control:") || line.starts_with("task:");
    if (!control) out << line << "\n";
  }
  out << "grasp: {press: 1 N}\n";
  out.close();
  const Model model = build_model(load_scene(file, {"object.points=6000", "gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]"}));
  ASSERT_TRUE(model.scene.torques);
  State state(model);
  Controller controller(model);
  Frame frame(model);
  ContactMemory memory(model);
  ContactScratch work(model);
  PerFinger<double> first_N(model.fingers());
  for (int tick = 0; tick < 100; ++tick) {
    (void)control_tick(model, state, controller, frame);
    (void)contact_tick(model, frame, memory, work, state);
    for (int k = 0; k < model.fingers(); ++k) {
      if (tick == 0) first_N[k] = state.load[k].normal_N;
      EXPECT_NEAR(state.load[k].normal_N, first_N[k], 0.05 * first_N[k]) << k << " at " << tick;
    }
  }
}

TEST(SceneGrasp, RefusesWhatContradictsIt) {
  EXPECT_EQ(fault_of({"grasp=auto", "object.position=[0 m, 0 m, 0 m]"}),
            "object.position: is what grasp finds: leave out one of them");
  EXPECT_EQ(fault_of({"grasp={fingers: [thumb, toe]}"}), "grasp.fingers: the hand has no finger 'toe'");
  EXPECT_EQ(fault_of({"grasp={fingers: [thumb, indx]}"}),
            "grasp.fingers: the hand has no finger 'indx', did you mean 'index'?");
  EXPECT_EQ(fault_of({"grasp=atuo"}),
            "grasp: 'atuo' is neither auto nor a map of keys and values, did you mean 'auto'?");
  EXPECT_EQ(fault_of({"grasp={fingers: [thumb, thumb]}"}), "grasp.fingers: names 'thumb' twice");
  EXPECT_EQ(fault_of({"grasp={axis: [0, 0, 0]}"}), "grasp.axis: a direction must not be zero");
  EXPECT_EQ(fault_of({"grasp={at: [0 mm, 0 mm, 40 mm]}"}),
            "grasp.at: must lie within the object: -25 .. 25, -25 .. 25, -25 .. 25 mm in its frame");
  EXPECT_EQ(fault_of({"grasp={press: 1 N}"}),
            "control.grasp.internal_force: is what grasp.press asks for: leave out one of them");
  EXPECT_EQ(fault_of({"grasp={fingers: [index]}"}).substr(0, 17), "grasp: one finger");
  EXPECT_NE(fault_of({"grasp=auto", "object.shape={sphere: 120 mm}"}).find("and this hand opens"), std::string::npos);
  EXPECT_NE(fault_of({"grasp={rank: 20, axis: [1, 0, 0], at: [0 mm, 0 mm, 0 mm], approach: [0, 0, 1]}"})
                .find("grasp.rank: the search found "),
            std::string::npos);
}

// A scene of some fingers has their joints and muscles alone.
TEST(SceneGrasp, LeavesFingersOut) {
  const Scene scene = scene_of("minimal", {"hand.fingers=[thumb, major]",
                                           "hand.posture=[0 rad, 0 rad, 0 rad, 0.1 rad, 0 "
                                           "rad, 0 rad, 0.1 rad, 0.1 rad]"});
  EXPECT_EQ(scene.hand.fingers(), 2);
  EXPECT_EQ(scene.hand.fingertips[1].finger, "major");
  EXPECT_EQ(scene.posture.size(), 8);
}

}  // namespace
}  // namespace thenar::scene_grasp_test
