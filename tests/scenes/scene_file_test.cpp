// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/scene_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <variant>
#include <vector>

#include "engine/formats/files.h"
#include "engine/grasp/model.h"
#include "engine/scenes/config.h"
#include "engine/scenes/shared_data.h"
#include "tests/support/scenes.h"
#include "tests/support/small_scenes.h"

namespace thenar::scene_file_test {
namespace {

using namespace small_scenes;

using Eigen::Vector3d;

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

// Of a shape that is misspelt it is not known how large it is, nor whether it has points.
TEST(Scene, AShapeThatIsRefusedRefusesNothingElse) {
  try {
    (void)scene_of("minimal", {"object.shape={spher: 26 mm}", "object.centre_of_mass=[1 mm, 0 mm, 0 mm]"});
    FAIL() << "the shape is not refused";
  } catch (const ConfigError& error) {
    EXPECT_EQ(std::string(error.what()).find("must lie within"), std::string::npos) << error.what();
  }
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

// The weight of a solid acts at its centroid, unless the scene says where.
TEST(Scene, ReadsTheCentreOfMass) {
  const std::string mug = "mug: {radius: 25 mm, height: 60 mm, wall: 4 mm, handle: {radius: 12 mm, thickness: 8 mm}}";
  const Scene filled = scene_with_shape(mug);
  EXPECT_EQ(filled.object.centre_of_mass_m, centroid_m(std::get<Mug>(filled.object.shape)));
  EXPECT_GT(filled.object.centre_of_mass_m.x(), 1e-3) << "the handle";
  const Scene named = scene_of("minimal", {"object.shape={" + mug + "}", "object.centre_of_mass=[1 mm, 2 mm, -3 mm]"});
  EXPECT_EQ(named.object.centre_of_mass_m, Vector3d(0.001, 0.002, -0.003));
  for (const char* shape : {"box: [50 mm, 40 mm, 30 mm]", "cylinder: {radius: 12 mm, length: 90 mm}", "cloud: a.obj"}) {
    const Scene scene = scene_with_shape(shape);
    EXPECT_EQ(scene.object.centre_of_mass_m, Vector3d::Zero()) << shape;
    EXPECT_EQ(std::ranges::count(scene.defaults_used, "object.centre_of_mass: [0 m, 0 m, 0 m]"), 1) << shape;
  }
}

TEST(Scene, ReadsPushes) {
  const std::vector<std::string> gone = {"task.push={force: [0 N, 0.5 N, 0 N], from: 0.5 s, over: 1 s}"};
  const Push plain = *scene_of("minimal", gone).task.push;
  EXPECT_EQ(plain.force_N, Vector3d(0.0, 0.5, 0.0));
  EXPECT_EQ(plain.at_m, Vector3d::Zero());
  EXPECT_EQ(plain.moment_Nm, Vector3d::Zero());
  const Push both = *scene_of("minimal", {"task.push={force: [0 N, 0.5 N, 0 N], at: [10 mm, 0 mm, -5 mm], moment: "
                                          "[1 N*mm, 0 N*mm, 0.002 N*m], from: 0.5 s, over: 1 s}"})
                         .task.push;
  EXPECT_EQ(both.at_m, Vector3d(0.01, 0.0, -0.005));
  EXPECT_EQ(both.moment_Nm, Vector3d(0.001, 0.0, 0.002));
  const Push moment =
      *scene_of("minimal", {"task.push={moment: [0 N*m, 0 N*m, 0.01 N*m], from: 0 s, over: 1 s}"}).task.push;
  EXPECT_EQ(moment.force_N, Vector3d::Zero());
  EXPECT_EQ(moment.moment_Nm, Vector3d(0.0, 0.0, 0.01));

  const auto fault = [](const std::string& push) {
    return fault_with({"task.push={" + push + ", from: 0 s, over: 1 s}"});
  };
  EXPECT_EQ(fault("at: [0 mm, 0 mm, 0 mm], moment: [0 N*m, 0 N*m, 0.01 N*m]"),
            "task.push.at: is where a force acts, and there is none: name it, or leave this out");
  EXPECT_EQ(
      fault("force: [0 N, 1 N, 0 N], at: [0 mm, 0 mm, 90 mm]"),
      "task.push.at: must lie within the object: -26.09 .. 26.09, -26.09 .. 26.09, -26.09 .. 26.09 mm in its frame");
  EXPECT_EQ(fault("moment: [0 N, 0 N*m, 0 N*m]"), "task.push.moment[0]: 0 N is not a torque: use N*m or N*mm");
  EXPECT_EQ(fault_with({"task.push={from: 0 s, over: 1 s}"}), "task.push.force: this key is missing");
}

TEST(Scene, TheGainHasItsUnit) {
  EXPECT_EQ(*scene_of("minimal", {"control.gain=12.5 N*m/rad"}).control->gain, 12.5);
  EXPECT_EQ(fault_with({"control.gain=12.5"}), "control.gain: 12.5 has no unit: use N*m/rad");
  EXPECT_EQ(fault_with({"control.gain=12.5 N/m"}), "control.gain: 12.5 N/m is not a rotational stiffness: use N*m/rad");
  EXPECT_EQ(fault_with({"control.gain=0 N*m/rad"}), "control.gain: 0 N*m/rad must be greater than zero");
}

// Each of these sizes memory or becomes a whole number: without a bound a line of text asks for any of it.
TEST(Scene, BoundsTimesAndCountsThatSizeMemory) {
  const std::string step = "time.step=1 ms", period = "time.control_period=10 ms";
  EXPECT_EQ(fault_with({step, period, "time.control_delay=1 s"}), "");
  for (const char* delay : {"1.001 s", "4294967.296 s"}) {
    EXPECT_EQ(fault_with({step, period, std::string("time.control_delay=") + delay}),
              "time.control_delay: must not be longer than 100 times time.control_period");
  }
  EXPECT_EQ(fault_with({step, "time.control_period=10 s"}), "");
  for (const char* longer : {"10.01 s", "1e9 s"}) {
    EXPECT_EQ(fault_with({step, std::string("time.control_period=") + longer}),
              "time.control_period: must not be longer than 10000 times time.step");
  }
  EXPECT_EQ(fault_with({"time.step=10 us", "time.duration=1 s"}), "");
  for (const std::string bad : {"9.9 us", "1e-300 s"}) {
    EXPECT_EQ(fault_with({"time.step=" + bad, "time.duration=1 ms"}), "time.step: " + bad + " must be at least 10 us");
  }
  for (const std::string bad : {"1.01 s", "1e300 s"}) {
    EXPECT_EQ(fault_with({"time.step=" + bad, "time.duration=1 ms"}), "time.step: " + bad + " must be at most 1 s");
  }
  EXPECT_EQ(fault_with({"time.step=1 ms", "time.duration=0.4 ms"}),
            "time.duration: must not be shorter than time.step");
  EXPECT_EQ(fault_with({step, "time.duration=1e8 s"}), "time.duration: makes more than 10 million steps of time.step");
  EXPECT_EQ(fault_with({step, "time.duration=1e300 s"}), "time.duration: 1e300 s must be at most 1e9 s");
  EXPECT_EQ(fault_with({"object.points=1000001"}), "object.points: 1000001 must be at most 1000000");
  // The scene without fingertips lacks their other keys.
  try {
    (void)scene_of("box_grasp", {"fingertips.leaves=4001", "fingertips.points=5000"});
    ADD_FAILURE() << "a kernel of 4001 x 4001";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(), "--set fingertips.leaves: 4001 must be at most 4000");
  }
}

// A hand that cannot be read is one fault among others, at the place that names it.
TEST(Scene, AMissingHandHidesNoOtherFault) {
  try {
    (void)scene_of("minimal", {"hand.model=nowhere.yaml", "hand.joint_viscosity=1", "contact.friction=-1"});
    ADD_FAILURE() << "three faults";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "--set hand.model: nowhere.yaml: no such file\n"
                 "--set hand.joint_viscosity: 1 has no unit: use N*m*s or N*m*s/rad\n"
                 "--set contact.friction: -1 must be at least 0");
  }
  const std::filesystem::path file = std::filesystem::path(THENAR_TEST_OUTPUT) / "handless.yaml";
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file) << "name: handless\nhand: {model: nowhere.yaml}\n";
  try {
    (void)load_scene(file);
    ADD_FAILURE() << "no hand";
  } catch (const ConfigError& error) {
    const std::string missing = (file.parent_path() / "nowhere.yaml").string() + ": no such file";
    EXPECT_NE(std::string(error.what()).find(file.string() + ":2:15: hand.model: " + missing), std::string::npos)
        << error.what();
  }
  // Alone it is no fault of the scene.
  try {
    (void)scene_of("minimal", {"hand.model=nowhere.yaml"});
    ADD_FAILURE() << "no hand";
  } catch (const ReadError& error) {
    EXPECT_STREQ(error.what(), "--set hand.model: nowhere.yaml: no such file");
  }
}

// A count that is refused is not compared with another.
// A copy of a scene works wherever it lies; a hand of the same name beside it goes before the program's own.
TEST(Scene, TakesTheHandThatComesWithTheProgram) {
  const std::filesystem::path folder = std::filesystem::path(THENAR_TEST_OUTPUT) / "copied_scene";
  std::filesystem::create_directories(folder);
  std::filesystem::remove(folder / "hand.yaml");
  const std::filesystem::path copy = folder / "minimal.yaml";
  std::filesystem::copy_file(config_file("minimal"), copy, std::filesystem::copy_options::overwrite_existing);
  EXPECT_EQ(load_scene(copy).hand.muscles.size(), 23U);
  EXPECT_EQ(scene_files(copy, {})[1], shared_data() / "scenes" / "hand.yaml");
  std::ofstream(folder / "hand.yaml") << "joints: []\n";
  EXPECT_THROW((void)load_scene(copy), ConfigError);
}

TEST(Scene, ARefusedCountHasNoOtherFault) {
  try {
    (void)scene_of("box_grasp", {"fingertips.points=0"});
    ADD_FAILURE() << "no points";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(), "--set fingertips.points: 0 must be at least 1");
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
  EXPECT_EQ(fault_of("cloud: a.pcd"), "object.points: a point cloud brings its own points: leave this out");
  // Of a .ply its header tells; one that is not there is what the scene takes it for.
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n";
  const auto folder = std::filesystem::path(THENAR_TEST_OUTPUT) / "points_of_ply";
  std::filesystem::create_directories(folder);
  const std::string file = (folder / "a.ply").string();
  write_file(file, head + "end_header\n");
  EXPECT_EQ(fault_of("cloud: \"" + file + "\""), "object.points: a point cloud brings its own points: leave this out");
  write_file(file, head + "element face 1\nproperty list uchar int vertex_indices\nend_header\n");
  EXPECT_EQ(scene_with_shape("cloud: \"" + file + "\"").object.points, 2000);
  EXPECT_EQ(scene_with_shape("cloud: missing.ply").object.points, 2000);
}

TEST(Scene, RefusesShapesThatAreNone) {
  EXPECT_EQ(fault_of("ellipsoid: [50 mm, 40 mm, 11 m]"), "object.shape.ellipsoid[2]: 11 m must be at most 10 m");
  EXPECT_EQ(fault_of("cylinder: {radius: 1 um, length: 90 mm}"),
            "object.shape.cylinder.radius: 1 um must be at least 0.1 mm");
  EXPECT_EQ(fault_of("cylinder: {radius: 12 mm}"), "object.shape.cylinder.length: this key is missing");
  const std::string exponents = "object.shape.superquadric.exponents";
  EXPECT_EQ(fault_of("superquadric: {size: [24 mm, 24 mm, 90 mm], exponents: [0, 1]}"),
            exponents + "[0]: 0 must be at least 0.1");
  EXPECT_EQ(fault_of("superquadric: {size: [24 mm, 24 mm, 90 mm], exponents: [1, 2.5]}"),
            exponents + "[1]: 2.5 must be at most 2");
  EXPECT_EQ(fault_of("mug: {radius: 27 mm, height: 80 mm, wall: 27 mm}"),
            "object.shape.mug.wall: must be less than radius and height");
  for (const char* handle : {"radius: 18 mm, thickness: 36 mm", "radius: 25 mm, thickness: 4 mm"}) {
    const std::string fault =
        fault_of("mug: {radius: 27 mm, height: 80 mm, wall: 3 mm, handle: {" + std::string(handle) + "}}");
    EXPECT_TRUE(fault.starts_with("object.shape.mug.handle: ")) << fault;
  }
}

}  // namespace
}  // namespace thenar::scene_file_test
