// SPDX-License-Identifier: Apache-2.0
// Gravity and rotations in each form in which a scene may write them, against matrices that are computed here.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/scene_text.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::scene_forms_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A scene reads decimal numbers, and a rotation from them rounds some times more.
constexpr double kRounding = 1e-14;

/// The one message about a change, with its key; empty if the scene is read.
std::string fault_with(const std::string& change, const std::string& scene = "minimal") {
  try {
    (void)scene_of(scene, {change});
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.diagnostics().size(), 1U) << error.what();
    return error.diagnostics()[0].key + ": " + error.diagnostics()[0].message;
  }
  return "";
}

Matrix3d object_rotation(const std::string& form) {
  return scene_of("minimal", {"object.rotation=" + form}).object.X_WO.linear();
}

TEST(SceneForms, GravityIsADirectionAndAMagnitude) {
  EXPECT_EQ(scene_of("minimal", {"gravity={down: [0, 0, -2]}"}).gravity, Vector3d(0.0, 0.0, -9.81));
  const Scene slanted = scene_of("minimal", {"gravity={down: [3, 0, 4], magnitude: 1.62 m/s^2}"});
  EXPECT_LT((slanted.gravity - 1.62 * Vector3d(0.6, 0.0, 0.8)).norm(), kRounding);
  EXPECT_FALSE(slanted.gravity_in_object_frame);
  EXPECT_TRUE(scene_of("minimal", {"gravity={down: [1, 0, 0], magnitude: 0 m/s^2}"}).gravity.isZero(0.0));
  EXPECT_EQ(scene_of("minimal", {"gravity=[0 m/s^2, 1 m/s^2, 0 m/s^2]"}).gravity, Vector3d::UnitY());
}

TEST(SceneForms, RefusesGravityThatPointsNowhereOrUp) {
  EXPECT_EQ(fault_with("gravity={down: [0, 0, 0]}"), "gravity.down: a direction must not be zero");
  EXPECT_EQ(fault_with("gravity={down: [0, 0, 1], magnitude: -1 m/s^2}"),
            "gravity.magnitude: -1 m/s^2 must not be negative");
  EXPECT_EQ(fault_with("gravity={magnitude: 1 m/s^2}"), "gravity.down: this key is missing");
  EXPECT_EQ(fault_with("gravity={down: [0, 0, 1], magnitude: 1}"), "gravity.magnitude: 1 has no unit: use m/s^2");
}

// Gravity in the object's frame stays there until the object's pose is known, in the file that is written, too.
TEST(SceneForms, GravityOfTheObjectIsWrittenAsSuch) {
  const Scene scene = scene_of("minimal", {"gravity={down: [0, 0, -1], frame: object}"});
  EXPECT_TRUE(scene.gravity_in_object_frame);
  EXPECT_EQ(scene.gravity, Vector3d(0.0, 0.0, -9.81));
  SceneTextNotes notes;
  notes.hand = config_file("hand");
  const std::filesystem::path file = scratch() / "scene.yaml";
  write_file(file, scene_text(scene, notes));
  const Scene again = load_scene(file);
  EXPECT_TRUE(again.gravity_in_object_frame);
  EXPECT_EQ(again.gravity, scene.gravity);
}

// Whatever the axis and its length, the angle, the order and the signs: products of Eigen's turns about one axis are
// the reference.
TEST(SceneForms, RotationsAgreeWithProductsOfTurns) {
  const std::uint64_t seed = std::random_device{}();
  std::mt19937_64 random(seed);
  SCOPED_TRACE(fmt::format("seed {}", seed));
  constexpr double kDegree = std::numbers::pi / 180.0;
  const std::vector<std::string> orders{"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"};
  for (int i = 0; i < 20; ++i) {
    const Vector3d axis = uniform(random, 0.1, 3.0) * random_direction(random);
    const double angle_deg = uniform(random, -200.0, 200.0);
    const Matrix3d by_axis = AngleAxisd(angle_deg * kDegree, axis.normalized()).toRotationMatrix();
    EXPECT_TRUE(object_rotation(fmt::format("{{axis: [{:.17g}, {:.17g}, {:.17g}], angle: {:.17g} deg}}", axis.x(),
                                            axis.y(), axis.z(), angle_deg))
                    .isApprox(by_axis, kRounding));

    const Vector3d euler_deg(angle_deg, uniform(random, -200.0, 200.0), uniform(random, -200.0, 200.0));
    const std::string& order = orders[static_cast<std::size_t>(i) % orders.size()];
    Matrix3d R[3];
    for (int j = 0; j < 3; ++j) R[j] = AngleAxisd(euler_deg[j] * kDegree, Vector3d::Unit(order[j] - 'x'));
    EXPECT_TRUE(object_rotation(fmt::format("{{euler: [{:.17g} deg, {:.17g} deg, {:.17g} deg], order: {}}}",
                                            euler_deg.x(), euler_deg.y(), euler_deg.z(), order))
                    .isApprox(R[2] * R[1] * R[0], kRounding))
        << order << ": the axes are fixed, and the first turn is the innermost";

    const Eigen::Quaterniond q(by_axis);
    const double length = uniform(random, 0.1, 3.0);
    EXPECT_TRUE(object_rotation(fmt::format("{{quaternion: [{:.17g}, {:.17g}, {:.17g}, {:.17g}]}}", length * q.w(),
                                            length * q.x(), length * q.y(), length * q.z()))
                    .isApprox(by_axis, kRounding));
  }
}

// URDF's rpy: roll about the fixed x, then pitch about the fixed y, then yaw about the fixed z.
TEST(SceneForms, EulerWithoutAnOrderIsRollPitchAndYaw) {
  const Matrix3d R = object_rotation("{euler: [90 deg, 0 deg, 90 deg]}");
  EXPECT_LT((R * Vector3d::UnitY() - Vector3d::UnitZ()).norm(), kRounding) << "y is rolled up, and yaw leaves it";
  EXPECT_LT((R * Vector3d::UnitX() - Vector3d::UnitY()).norm(), kRounding) << "x is yawed alone";
}

TEST(SceneForms, EveryRotationHasEveryForm) {
  const Matrix3d R = AngleAxisd(std::numbers::pi / 6.0, Vector3d::UnitZ()).toRotationMatrix();
  for (const std::string form : {"{axis: [0, 0, 1], angle: 30 deg}", "{euler: [0 deg, 0 deg, 30 deg]}",
                                 "{quaternion: [0.96592582628906829, 0, 0, 0.25881904510252074]}",
                                 "[[0.86602540378443865, -0.5, 0], [0.5, 0.86602540378443865, 0], [0, 0, 1]]"}) {
    SCOPED_TRACE(form);
    EXPECT_TRUE(object_rotation(form).isApprox(R, kRounding));
    const Scene scene =
        scene_of("resting_box", {"environment.bodies[0].rotation=" + form, "task.goal={rotation: " + form + "}"});
    EXPECT_TRUE(scene.environment->bodies[0].X_WE.linear().isApprox(R, kRounding));
    EXPECT_TRUE(scene.task.goal->rotation->isApprox(R, kRounding));
  }
}

TEST(SceneForms, RefusesHalvesAndMixturesOfRotations) {
  const auto fault = [](const std::string& form) { return fault_with("object.rotation=" + form); };
  EXPECT_EQ(fault("{axis: [0, 0, 1]}"), "object.rotation.angle: is missing: by how much it turns about the axis");
  EXPECT_EQ(fault("{angle: 30 deg}"), "object.rotation.axis: is missing: what the angle is about");
  EXPECT_EQ(fault("{axis: [0, 0, 0], angle: 30 deg}"), "object.rotation.axis: a direction must not be zero");
  EXPECT_EQ(fault("{euler: [0 deg, 0 deg, 1]}"), "object.rotation.euler[2]: 1 has no unit: use rad or deg");
  EXPECT_EQ(fault("{order: zyx, axis: [0, 0, 1], angle: 1 deg}"),
            "object.rotation.order: is that of euler: name that, too");
  EXPECT_EQ(fault("{quaternion: [0, 0, 0, 0]}"), "object.rotation.quaternion: must not be zero");
  EXPECT_EQ(fault("{}"), "object.rotation: needs one of axis with angle, euler, quaternion");
  EXPECT_EQ(fault("{axis: [0, 0, 1], angle: 1 deg, quaternion: [1, 0, 0, 0]}"),
            "object.rotation.quaternion: only one of axis with angle, euler and quaternion may be given");
  EXPECT_EQ(fault("{rpy: [0 deg, 0 deg, 1 deg]}"),
            "object.rotation.rpy: unknown key, did you mean 'object.rotation.euler'?");
}

// Other words for a key, and words in the place of a map.
TEST(SceneForms, HintsAtWhatToWrite) {
  EXPECT_EQ(fault_with("object.shape={cylinder: {diameter: 20 mm, length: 50 mm}}"),
            "object.shape.cylinder.diameter: unknown key, did you mean 'object.shape.cylinder.radius'? (half the "
            "diameter)");
  const std::string capsule = fault_with("object.shape={capsule: {radius: 5 mm}}");
  EXPECT_EQ(capsule.substr(0, 81), "object.shape.capsule: unknown key, did you mean 'object.shape.superquadric'?: a c")
      << capsule;
}

TEST(SceneForms, AWordThatStandsForAMapGivesWayToOne) {
  const Scene scene = scene_of("found_carry", {"grasp=auto", "grasp.press=1 N", "control.grasp={friction: 0.4}"});
  EXPECT_EQ(scene.grasp->press_N, 1.0);
  EXPECT_EQ(fault_with("gravity.down=[0, 0, 1]", "box_grasp"),
            "gravity.down: gravity is not a map of keys and values: write the whole of it, as in --set "
            "'gravity={down: [0, 0, 1]}'");
}

}  // namespace
}  // namespace thenar::scene_forms_test
