// SPDX-License-Identifier: Apache-2.0
#include "engine/models/object_surface.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "collision/shapes.h"
#include "engine/formats/files.h"
#include "engine/grasp/model.h"
#include "engine/models/build_model.h"
#include "tests/support/small_scenes.h"

namespace thenar::object_surface_test {
namespace {

using namespace small_scenes;

TEST(Scene, MakesASurfaceOfEveryShape) {
  for (const char* shape :
       {"box: [50 mm, 40 mm, 30 mm]", "sphere: 25 mm", "ellipsoid: [50 mm, 40 mm, 30 mm]",
        "cylinder: {radius: 25 mm, length: 30 mm}", "superquadric: {size: [50 mm, 40 mm, 30 mm], exponents: [0.3, 1]}",
        "mug: {radius: 25 mm, height: 30 mm, wall: 10 mm, handle: {radius: 9 mm, thickness: 8 mm}}"}) {
    const Model model = build_model(scene_with_shape(shape));
    EXPECT_EQ(model.object.cloud().points_m.cols(), 2000) << shape;
    // Samples reach the ends of the shape, but for about a spacing.
    EXPECT_NEAR(model.object.bounds().sizes().z(), shape[0] == 's' && shape[1] == 'p' ? 0.05 : 0.03, 1e-3) << shape;
  }
}

/// A scene with a file of this text.
Scene scene_of_file(const std::string& name, const std::string& text) {
  const auto folder = std::filesystem::path(THENAR_TEST_OUTPUT) / "object_surface";
  std::filesystem::create_directories(folder);
  write_file(folder / name, text);
  Scene scene = scene_with_shape("sphere: 25 mm");
  scene.object.shape = CloudShape{.file = folder / name, .unit_m = 1e-3};
  return scene;
}

/// A box as lines `v` and `f` of OBJ, whose vertices are counted from `first` on.
std::string box_lines(const Eigen::Vector3d& low, const Eigen::Vector3d& high, int first) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    text += "v";
    for (int k = 0; k < 3; ++k) text += " " + std::to_string((i >> k & 1) != 0 ? high[k] : low[k]);
    text += "\n";
  }
  for (const auto& face : std::vector<std::vector<int>>{
           {0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}) {
    text += "f";
    for (const int i : face) text += " " + std::to_string(first + i);
    text += "\n";
  }
  return text;
}

// The centre of mass is that of what a mesh encloses, to the last digits, whatever samples stand for it.
TEST(Scene, FindsTheCentreOfAMesh) {
  const auto centre_mm = [](const std::string& text) {
    const Scene scene = scene_of_file("solids.obj", text);
    std::vector<std::string> notes;
    const ImplicitSurface surface = make_object_surface(scene, notes);
    return Eigen::Vector3d(1e3 * object_solid(scene, surface, notes).centroid_m);
  };
  const std::string box = box_lines({0, 0, 0}, {30, 40, 60}, 1);
  EXPECT_LT((centre_mm(box) - Eigen::Vector3d(15, 20, 30)).norm(), 1e-9);
  EXPECT_LT((centre_mm(box + box_lines({0, 0, 60}, {30, 20, 90}, 9)) -
             Eigen::Vector3d(15, (72 * 20 + 18 * 10) / 90.0, (72 * 30 + 18 * 75) / 90.0))
                .norm(),
            1e-9);
  EXPECT_LT((centre_mm(box + box_lines({10, 10, 10}, {20, 20, 25}, 9)) - Eigen::Vector3d(15, 20, 30)).norm(), 0.02);
}

// Vectors that are not the surface's normals, here of axes in another order, are left out, in words, and the surface is
// the ball's all the same: its centre is off by 0.3 mm with either, for its samples are 2.3 mm apart. Own normals stay.
TEST(Scene, LeavesOutVectorsThatAreNotItsNormals) {
  const PointCloud ball = sample_sphere(25.0, 1500);
  for (const bool are_own : {false, true}) {
    SCOPED_TRACE(are_own);
    std::string text;
    for (Eigen::Index i = 0; i < ball.points_m.cols(); ++i) {
      const Eigen::Vector3d at = ball.points_m.col(i);
      const Eigen::Vector3d own = ball.normals.col(i), n = are_own ? own : Eigen::Vector3d(own.y(), own.z(), own.x());
      text += fmt::format("{} {} {} {} {} {}\n", at.x(), at.y(), at.z(), n.x(), n.y(), n.z());
    }
    const Scene scene = scene_of_file("vectors.xyz", text);
    std::vector<std::string> notes;
    const ImplicitSurface surface = make_object_surface(scene, notes);
    const auto says = [&](const char* what) {
      return std::ranges::any_of(notes, [&](const std::string& note) { return note.find(what) != std::string::npos; });
    };
    EXPECT_NE(says("left out the file's normals: "), are_own);
    EXPECT_NE(says("estimated the normals"), are_own);
    EXPECT_LT(object_solid(scene, surface, notes).centroid_m.norm(), 0.5e-3);
  }
}

// A slit of 30 um, whose walls face each other nearer than samples tell apart: its file has no normals to be oriented.
TEST(Scene, SaysWhatWouldMendAMesh) {
  std::string text, front = "f", back = "f";
  const std::vector<Eigen::Vector2d> outline = {{0, 0},      {30, 0},     {30, 60},     {15.015, 60},
                                                {15.015, 5}, {14.985, 5}, {14.985, 60}, {0, 60}};
  const int count = static_cast<int>(outline.size());
  for (const double y : {0.0, 40.0}) {
    for (const Eigen::Vector2d& at : outline) {
      text += "v " + std::to_string(at.x()) + " " + std::to_string(y) + " " + std::to_string(at.y()) + "\n";
    }
  }
  for (int i = 0; i < count; ++i) {
    const int next = (i + 1) % count;
    front += " " + std::to_string(1 + i);
    back += " " + std::to_string(2 * count - i);
    text += "f " + std::to_string(1 + next) + " " + std::to_string(1 + i) + " " + std::to_string(1 + count + i) + " " +
            std::to_string(1 + count + next) + "\n";
  }
  std::vector<std::string> notes;
  try {
    (void)make_object_surface(scene_of_file("slit.obj", text + front + "\n" + back + "\n"), notes);
    ADD_FAILURE();
  } catch (const FileError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("unite its parts into one closed surface"), std::string::npos) << what;
    EXPECT_EQ(what.find("orient them"), std::string::npos) << what;
  }
}

}  // namespace
}  // namespace thenar::object_surface_test
