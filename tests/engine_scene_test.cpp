#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include "engine/config.h"
#include "engine/model.h"
#include "tests/scenes.h"

namespace thenar {
namespace {

using Eigen::Vector3d;

Scene scene_with_shape(const std::string& shape) {
  return scene_of("minimal", {"object.shape={" + shape + "}", "object.points=2000"});
}

template <typename Kind>
Kind shape_of(const std::string& text) {
  return std::get<Kind>(scene_with_shape(text).object.shape);
}

/// The one message about this shape, with its key; empty if it is read.
std::string fault_of(const std::string& shape) {
  try {
    (void)scene_with_shape(shape);
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.diagnostics().size(), 1U) << error.what();
    return error.diagnostics()[0].key + ": " + error.diagnostics()[0].message;
  }
  return "";
}

TEST(Scene, ReadsEveryShape) {
  EXPECT_EQ(shape_of<BoxShape>("box: [50 mm, 40 mm, 30 mm]").size_m, Vector3d(0.05, 0.04, 0.03));
  EXPECT_EQ(shape_of<SphereShape>("sphere: 25 mm").radius_m, 0.025);
  EXPECT_EQ(shape_of<EllipsoidShape>("ellipsoid: [50 mm, 40 mm, 30 mm]").size_m, Vector3d(0.05, 0.04, 0.03));
  const auto cylinder = shape_of<CylinderShape>("cylinder: {radius: 12 mm, length: 90 mm}");
  EXPECT_EQ(cylinder.radius_m, 0.012);
  EXPECT_EQ(cylinder.length_m, 0.09);
  const auto shape = shape_of<SuperquadricShape>("superquadric: {size: [24 mm, 24 mm, 90 mm], exponents: [0.3, 1]}");
  EXPECT_EQ(shape.size_m, Vector3d(0.024, 0.024, 0.09));
  EXPECT_EQ(shape.exponents.north_south, 0.3);
  EXPECT_EQ(shape.exponents.east_west, 1.0);
  const auto mug =
      shape_of<Mug>("mug: {radius: 27 mm, height: 80 mm, wall: 3 mm, handle: {radius: 18 mm, thickness: 8 mm}}");
  EXPECT_EQ(mug.radius_m, 0.027);
  EXPECT_EQ(mug.height_m, 0.08);
  EXPECT_EQ(mug.wall_m, 0.003);
  ASSERT_TRUE(mug.handle);
  EXPECT_EQ(mug.handle->radius_m, 0.018);
  EXPECT_EQ(mug.handle->thickness_m, 0.008);
  EXPECT_FALSE(shape_of<Mug>("mug: {radius: 27 mm, height: 80 mm, wall: 3 mm}").handle);
}

TEST(Scene, MakesASurfaceOfEveryShape) {
  for (const char* shape :
       {"box: [50 mm, 40 mm, 30 mm]", "sphere: 25 mm", "ellipsoid: [50 mm, 40 mm, 30 mm]",
        "cylinder: {radius: 25 mm, length: 30 mm}", "superquadric: {size: [50 mm, 40 mm, 30 mm], exponents: [0.3, 1]}",
        "mug: {radius: 25 mm, height: 30 mm, wall: 10 mm, handle: {radius: 9 mm, thickness: 8 mm}}"}) {
    const Model model(scene_with_shape(shape));
    EXPECT_EQ(model.object.cloud().points_m.cols(), 2000) << shape;
    // Samples reach the ends of the shape, but for about a spacing.
    EXPECT_NEAR(model.object.bounds().sizes().z(), shape[0] == 's' && shape[1] == 'p' ? 0.05 : 0.03, 1e-3) << shape;
  }
}

TEST(Scene, ReadsTheUnitOfACloud) {
  const auto cloud = [](const std::string& shape, const std::string& points = "object.points=500") {
    return std::get<CloudShape>(scene_of("minimal", {"object.shape={" + shape + "}", points}).object.shape);
  };
  EXPECT_EQ(cloud("cloud: a.obj").file, "a.obj");
  EXPECT_EQ(cloud("cloud: a.obj").unit_m, 1.0);
  EXPECT_EQ(cloud("cloud: {file: a.obj}").unit_m, 1.0);
  EXPECT_EQ(cloud("cloud: {file: a.obj, unit: mm}").unit_m, 1e-3);
  EXPECT_EQ(cloud("cloud: {file: a.obj, unit: 25.4 mm}").unit_m, 25.4e-3);
  const std::vector<std::string> defaults = scene_with_shape("cloud: {file: a.obj}").defaults_used;
  EXPECT_EQ(std::ranges::count(defaults, "object.shape.cloud.unit: 1 m"), 1);
  EXPECT_EQ(fault_of("cloud: {file: a.obj, unit: mile}").substr(0, 25), "object.shape.cloud.unit: ");
  EXPECT_EQ(fault_of("cloud: {file: a.obj, unit: -1 mm}"), "object.shape.cloud.unit: -1 mm must be greater than zero");
  EXPECT_EQ(fault_of("cloud: {unit: mm}"), "object.shape.cloud.file: this key is missing");
}

TEST(Scene, AsksForPointsOfAMeshAlone) {
  EXPECT_EQ(scene_with_shape("cloud: a.stl").object.points, 2000);
  EXPECT_EQ(fault_of("cloud: a.ply"), "object.points: a point cloud brings its own points: leave this out");
}

TEST(Scene, RefusesShapesThatAreNone) {
  const std::string in_range = "must measure 0.1 mm to 10 m";
  EXPECT_EQ(fault_of("ellipsoid: [50 mm, 40 mm, 11 m]"), "object.shape.ellipsoid: " + in_range);
  EXPECT_EQ(fault_of("cylinder: {radius: 1 um, length: 90 mm}"), "object.shape.cylinder.radius: " + in_range);
  EXPECT_EQ(fault_of("cylinder: {radius: 12 mm}"), "object.shape.cylinder.length: this key is missing");
  const std::string range = "object.shape.superquadric.exponents: must lie within 0.1 .. 2";
  EXPECT_EQ(fault_of("superquadric: {size: [24 mm, 24 mm, 90 mm], exponents: [0, 1]}"), range);
  EXPECT_EQ(fault_of("superquadric: {size: [24 mm, 24 mm, 90 mm], exponents: [1, 2.5]}"), range);
  EXPECT_EQ(fault_of("mug: {radius: 27 mm, height: 80 mm, wall: 27 mm}"),
            "object.shape.mug.wall: must be less than radius and height");
  for (const char* handle : {"radius: 18 mm, thickness: 36 mm", "radius: 25 mm, thickness: 4 mm"}) {
    const std::string fault =
        fault_of("mug: {radius: 27 mm, height: 80 mm, wall: 3 mm, handle: {" + std::string(handle) + "}}");
    EXPECT_TRUE(fault.starts_with("object.shape.mug.handle: ")) << fault;
  }
}

}  // namespace
}  // namespace thenar
