// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/scene_text.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "collision/shapes.h"
#include "engine/formats/files.h"
#include "engine/scenes/scene_file.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::scene_text_test {
namespace {

using Eigen::Vector3d;

Scene read_again(const Scene& scene, SceneTextNotes notes = {}) {
  notes.hand = config_file("hand");
  const std::filesystem::path file = scratch() / "scene.yaml";
  write_file(file, scene_text(scene, notes));
  return load_scene(file);
}

// A scene that was written is read back as the same one: writing it once more gives the same text, in which every value
// is, to its last digit.
TEST(SceneText, ReadsBackAsTheSameScene) {
  const std::vector<std::string> all{
      "time.control_delay=2 ms",
      "object.compliance={reduced_modulus: 1 MPa, poisson: 0.4,"
      " relaxation: 3 ms}",
      "task.rotate={by: 5 deg, about: [1, 2, 3], from: 1 s, over: 1 s}",
      "task.push={force: [0.1 N, 0 N, 0.2 N], at: [1 mm, 0 mm, 2 mm], moment: [1 N*mm, 0 "
      "N*m, 0 N*m], from: 1 s, over: 1 s}",
      "task.spring={translation: 50 N/m, rotation: 1 "
      "N*m/rad}",
      "fingertips.stiffening=0.5 1/N",
      "contact.level=auto",
      "model=auto",
      "tolerance={force: 2 %}",
      "environment={compliance: 1 um/N, friction: 0.1, bodies: [{shape: {sphere: 9 mm}, position: [1 m, 0 m, 0 m]},"
      " {shape: {cylinder: {radius: 4 mm, length: 9 mm}}, position: [1 m, 0 m, 0 m], friction: 0.7},"
      " {shape: {hole: {diameter: 8 mm, depth: 9 mm, chamfer: 1 mm}}, position: [1 m, 0 m, 0 m],"
      " move: [{by: [0 mm, 1 mm, 0 mm], from: 1 s, over: 2 s}]},"
      " {name: a b, shape: {box: [1 mm, 2 mm, 3 mm]}, position: [1 m, 0 m, 0 m]}]}"};
  for (const Scene& scene :
       {scene_of("box_grasp"), scene_of("minimal"), scene_of("stick"), scene_of("mug"), scene_of("box_grasp", all),
        scene_of("capsule"), scene_of("resting_box"), scene_of("minimal", {"hand.mirror=true", "hand.settle=true"})}) {
    SCOPED_TRACE(scene.name);
    SceneTextNotes notes;
    notes.hand = config_file("hand");
    Scene again = read_again(scene);
    EXPECT_EQ(again.posture, scene.posture);
    EXPECT_EQ(again.object.shape, scene.object.shape);
    // Rotations are made orthonormal to rounding when they are read.
    EXPECT_TRUE(again.object.X_WO.isApprox(scene.object.X_WO, 1e-14));
    again.object.X_WO = scene.object.X_WO;
    if (scene.environment) {
      EXPECT_TRUE(again.environment->bodies[0].X_WE.isApprox(scene.environment->bodies[0].X_WE, 1e-14));
      again.environment->bodies[0].X_WE = scene.environment->bodies[0].X_WE;
    }
    EXPECT_EQ(scene_text(again, notes), scene_text(scene, notes));
  }
}

// A body names its friction only where bodies differ in it.
TEST(SceneText, NamesTheFrictionOfBodiesOnce) {
  Scene scene = scene_of("resting_box");
  Environment& environment = *scene.environment;
  environment.bodies.push_back(environment.bodies[0]);
  EXPECT_NE(scene_text(scene, {}).find("environment:\n  friction: 0.3\n"), std::string::npos);
  environment.bodies[1].friction = 0.7;
  const std::string text = scene_text(scene, {});
  EXPECT_EQ(text.find("environment:\n  friction:"), std::string::npos);
  EXPECT_NE(text.find("friction: 0.3\n", text.find("environment:")), std::string::npos);
  EXPECT_NE(text.find("friction: 0.7\n", text.find("environment:")), std::string::npos);
}

TEST(SceneText, WritesWhatIsAskedOfAGrasp) {
  Scene scene = scene_to_begin_with(scene_of("minimal").hand, {"mug.obj", 1e-3}, 0.08, 0.6);
  SceneTextNotes notes;
  notes.object = "mug.obj";
  Scene again = read_again(scene, notes);
  ASSERT_TRUE(again.grasp);
  EXPECT_EQ(again.grasp->rank, 1);
  EXPECT_FALSE(again.grasp->press_N);
  scene.grasp = GraspWish{{0, 2, 1}, Vector3d::UnitX(), Vector3d(1e-3, 0.0, 2e-3), Vector3d::UnitZ(), 0.5, 2, 7};
  again = read_again(scene, notes);
  ASSERT_TRUE(again.grasp);
  EXPECT_EQ(again.grasp->fingers, scene.grasp->fingers);
  EXPECT_EQ(again.grasp->axis_O, scene.grasp->axis_O);
  EXPECT_EQ(again.grasp->at_O, scene.grasp->at_O);
  EXPECT_EQ(again.grasp->approach_O, scene.grasp->approach_O);
  EXPECT_EQ(again.grasp->press_N, scene.grasp->press_N);
  EXPECT_EQ(again.grasp->rank, 2);
  EXPECT_EQ(again.grasp->seed, 7U);
}

// Of evenly spread samples the sums of Gauss's law are means: a share of about the spacing over the size is forgiven.
TEST(EnclosedCentroid, IsThatOfTheSolid) {
  PointCloud cloud = sample_box({0.03, 0.05, 0.08}, 4000);
  const Vector3d t(0.1, -0.2, 0.05);
  cloud.points_m.colwise() += t;
  EXPECT_LT((enclosed_centroid_m(cloud) - t).norm(), 1e-3);
  const Mug mug{0.03, 0.08, 0.004, MugHandle{0.015, 0.008}};
  EXPECT_LT((enclosed_centroid_m(sample_mug(mug, 20000)) - centroid_m(mug)).norm(), 1.5e-3);
}

// A scan is dense where the scanner was near: here a ball at x > 0 ten times denser than at x < 0.
TEST(EnclosedCentroid, IsThatOfUnevenScans) {
  const PointCloud dense = sample_sphere(0.025, 8000);
  PointCloud scan;
  scan.points_m.resize(3, dense.points_m.cols());
  scan.normals.resize(3, dense.points_m.cols());
  Eigen::Index kept = 0;
  for (Eigen::Index i = 0; i < dense.points_m.cols(); ++i) {
    if (dense.points_m(0, i) < 0.0 && i % 10 != 0) continue;
    scan.points_m.col(kept) = dense.points_m.col(i);
    scan.normals.col(kept++) = dense.normals.col(i);
  }
  scan.points_m.conservativeResize(3, kept);
  scan.normals.conservativeResize(3, kept);
  EXPECT_LT(enclosed_centroid_m(scan).norm(), 1e-3);  // by their number alone 7.6 mm
}

}  // namespace
}  // namespace thenar::scene_text_test
