#include "engine/models/object_surface.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace thenar::object_surface_test
