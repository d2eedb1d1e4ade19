// SPDX-License-Identifier: Apache-2.0
// In the scenes that come with the program every contact on a smooth face is inside Coulomb's cone about the face's own
// normal, and on the face.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/cases/probe.h"
#include "collision/solids/exact_shape.h"
#include "tests/support/scenes.h"

namespace thenar::shipped_scenes_test {
namespace {

using Eigen::Vector3d;
using namespace truth;

class Shipped : public testing::TestWithParam<const char*> {};

TEST_P(Shipped, ContactsAreInsideTheConesOfExactNormals) {
  constexpr double kEdge_m = 2.5e-3, kEnd_s = 2.5;
  Loop loop(load_scene(std::filesystem::path(THENAR_CONFIGS) / (std::string(GetParam()) + ".yaml")));
  ASSERT_TRUE(loop.model.exact.has_value());
  int looked_at = 0;
  double most_ratio = 0.0, off_m = 0.0;
  while (loop.time_s() < std::min(kEnd_s, loop.model.scene.duration_s)) {
    loop.tick();
    if (loop.state.tick % 50 != 0 || loop.time_s() < 0.5) continue;
    for (const LoadedPoint& point : loaded_points(loop.model, loop)) {
      const SurfaceForm at = nearest_place(*loop.model.exact, point.x_O);
      if (face_at(*loop.model.exact, at.point_m, at.normal, kEdge_m) < 0) continue;
      const Split force = split(point.f_O, at.normal);
      if (force.normal_N < 1e-4) continue;
      most_ratio = std::max(most_ratio, force.friction_N / force.normal_N / loop.model.friction(loop.time_s()));
      off_m = std::max(off_m, std::abs(at.distance_m));
      ++looked_at;
    }
  }
  EXPECT_GT(looked_at, 100);
  EXPECT_LE(most_ratio, 1.01);
  EXPECT_LE(off_m, 5e-6);
}
INSTANTIATE_TEST_SUITE_P(Scenes, Shipped, testing::Values("mug", "capsule", "box_grasp"));

}  // namespace
}  // namespace thenar::shipped_scenes_test
