// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/shown_surface.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "engine/models/build_model.h"
#include "engine/models/object_surface.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::shown_surface_test {
namespace {

/// A box of 40 x 60 x 80 in an .off file, with a face left out or not.
std::filesystem::path box_file(bool whole) {
  const std::filesystem::path file = scratch() / "box.off";
  std::ofstream out(file);
  out << "OFF\n8 " << (whole ? 6 : 5) << " 0\n";
  for (int i = 0; i < 8; ++i) {
    out << ((i & 1) ? 20 : -20) << ' ' << ((i & 2) ? 30 : -30) << ' ' << ((i & 4) ? 40 : -40) << '\n';
  }
  out << "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n";
  if (whole) out << "4 1 3 7 5\n";
  return file;
}

Model with_shape(const Shape& shape, Eigen::Index points) {
  Scene scene = scene_of("minimal");
  scene.object.shape = shape;
  scene.object.points = points;
  std::vector<std::string> notes;
  return Model{.scene = scene, .object_notes = {}, .object = make_object_surface(scene, notes)};
}

// To the last bit, in metres: nobody needs to look at samples of a mesh.
TEST(ShownSurface, IsTheMeshOfTheFile) {
  const TriangleMesh mesh = shown_surface(with_shape(CloudShape{box_file(true), 1e-3}, 3000));
  EXPECT_EQ(mesh.vertices_m.cols(), 8);
  EXPECT_EQ(mesh.triangles.cols(), 12);
  EXPECT_EQ(mesh.vertices_m.rowwise().maxCoeff(), 1e-3 * Eigen::Vector3d(20, 30, 40));
}

// A mesh with a hole is no solid: what the fingers feel is shown, and where that is open, too, nothing.
TEST(ShownSurface, OfAMeshWithAHoleIsNotThatMesh) {
  Model model = with_shape(CloudShape{box_file(true), 1e-3}, 3000);
  box_file(false);
  const TriangleMesh mesh = shown_surface(model);
  EXPECT_GT(mesh.triangles.cols(), 1000);
  std::filesystem::remove(std::get<CloudShape>(model.scene.object.shape).file);
  EXPECT_EQ(shown_surface(model).triangles.cols(), mesh.triangles.cols()) << "nor is one that is gone";
}

TEST(ShownSurface, OfAGeneratedShapeIsMadeOfItsSamples) {
  const TriangleMesh mesh = shown_surface(build_model(scene_of("minimal")));
  EXPECT_GT(mesh.triangles.cols(), 100);
}

}  // namespace
}  // namespace thenar::shown_surface_test
