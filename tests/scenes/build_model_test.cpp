#include "engine/scenes/build_model.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/scenes/config.h"
#include "tests/scenes/small_scenes.h"
#include "tests/support/scenes.h"

namespace thenar::build_model_test {
namespace {

using namespace small_scenes;

using Eigen::Vector3d;

TEST(Scene, RefusesACentreOfMassOutsideOfTheObject) {
  const std::string key = "object.centre_of_mass", box = "object.shape={box: [50 mm, 40 mm, 30 mm]}";
  EXPECT_EQ(fault_with({box, key + "=[25 mm, -20 mm, 15 mm]"}), "") << "a corner";
  EXPECT_EQ(fault_with({box, key + "=[0 mm, 0 mm, 15.1 mm]"}),
            key + ": must lie within the object: -25 .. 25, -20 .. 20, -15 .. 15 mm in its frame");
  const std::string mug =
      "object.shape={mug: {radius: 25 mm, height: 30 mm, wall: 10 mm, handle: {radius: 9 mm, "
      "thickness: 8 mm}}}";
  EXPECT_EQ(fault_with({mug, key + "=[37.9 mm, 0 mm, 0 mm]"}), "") << "in the handle";
  EXPECT_EQ(fault_with({mug, key + "=[-37.9 mm, 0 mm, 0 mm]"}).substr(0, key.size()), key);
  EXPECT_EQ(fault_with({key + "=[0, 0 mm, 0 mm]"}), key + "[0]: 0 has no unit: use m, cm, mm or um");
  EXPECT_EQ(fault_with({key + "=3 mm"}).substr(0, key.size()), key);
  EXPECT_EQ(fault_with({key + "=[0 mm, 0 mm]"}).substr(0, key.size()), key);

  // What a file holds shows when the model is made.
  Scene scene = scene_of("minimal", {box, "object.points=2000"});
  scene.object.centre_of_mass_m = Vector3d(0.0, 0.0, 0.03);
  EXPECT_THROW((void)build_model(scene), ConfigError);
}

// Whoever watches a start sees every stage as it begins, once, and the model is the one that nobody watched.
TEST(Model, TellsTheStagesOfItsStartInTheirOrder) {
  std::vector<std::string> stages;
  const auto watch = [&](const char* stage) { stages.emplace_back(stage); };
  const Scene rigid = scene_of("minimal", {"object.points=2000"});
  const Model watched = build_model(rigid, watch), unseen = build_model(rigid);
  const std::vector<std::string> surface{"the object's samples", "faults among the samples", "the object's surface",
                                         "patches of the surface"};
  EXPECT_EQ(stages, surface);
  EXPECT_EQ(watched.object.cloud().points_m, unseen.object.cloud().points_m);

  stages.clear();
  (void)build_model(scene_of("box_grasp", {"object.points=2000"}), watch);
  std::vector<std::string> all = surface;
  all.emplace_back("the fingertips");
  EXPECT_EQ(stages, all);
}

}  // namespace
}  // namespace thenar::build_model_test
