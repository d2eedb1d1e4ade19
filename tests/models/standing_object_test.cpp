// SPDX-License-Identifier: Apache-2.0
// An environment that is placed by the object: what it stands on, and a grasp that is found there.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "collision/solids/sampled_solid.h"
#include "engine/environment/environment_contacts.h"
#include "engine/finder/hand_room.h"
#include "engine/models/build_model.h"
#include "engine/models/scene_environment.h"
#include "engine/results/scene_run.h"
#include "engine/scenes/config.h"
#include "tests/support/scenes.h"

namespace thenar::standing_object_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A length in which rounding shows, a thousandth of what a contact gives way by under 1 N.
constexpr double kRounding_m = 1e-10;

constexpr const char* kUpright = "gravity={down: [0, 0, -1], frame: object}";
constexpr const char* kTable =
    "environment={frame: object, friction: 0.3, bodies: [{name: table, shape: {plane: true}, under: object}]}";

std::string fault_with(const std::string& scene, const std::vector<std::string>& changes) {
  try {
    (void)build_model(scene_of(scene, changes));
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.diagnostics().size(), 1U) << error.what();
    return error.diagnostics()[0].key + ": " + error.diagnostics()[0].message;
  }
  return "";
}

/// The pose of the first body after the object was stood on it, by gravity in this direction, world axes.
Isometry3d stood_on(Scene scene, const std::string& body, const Vector3d& down) {
  scene.environment = scene_of("resting_box", {"environment={friction: 0.3, bodies: [" + body + "]}"}).environment;
  scene.gravity = 9.81 * down;
  std::vector<std::string> notes;
  stand_object(scene, make_object_surface(scene, notes));
  EXPECT_FALSE(scene.environment->bodies[0].under_gap_m);
  return scene.environment->bodies[0].X_WE;
}

// Whatever the object's pose and the way down, the lowest corner of a box lies in the plane, all others above it.
TEST(StandingObject, ABoxTouchesThePlaneWithItsLowestCorner) {
  const std::uint64_t seed = std::random_device{}();
  std::mt19937_64 random(seed);
  SCOPED_TRACE(fmt::format("seed {}", seed));
  Scene scene = scene_of("box_grasp", {kCoarseBox});
  const Vector3d half_m = 0.5 * std::get<BoxShape>(scene.object.shape).size_m;
  for (int i = 0; i < 10; ++i) {
    scene.object.X_WO = random_rotation_about({0.1, 0.2, -0.3}, random);
    const Vector3d down = random_direction(random);
    const Isometry3d X_WE = stood_on(scene, "{shape: {plane: true}, under: object, gap: 2 mm}", down);
    EXPECT_LT((X_WE.linear().col(2) + down).norm(), 1e-12) << "its normal is against gravity";
    EXPECT_TRUE((X_WE.linear().transpose() * X_WE.linear()).isIdentity(1e-12));
    double lowest_m = 1.0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3d signs(corner % 2 == 0 ? 1.0 : -1.0, corner / 2 % 2 == 0 ? 1.0 : -1.0, corner < 4 ? 1.0 : -1.0);
      const Vector3d p_W = scene.object.X_WO * half_m.cwiseProduct(signs);
      lowest_m = std::min(lowest_m, (X_WE.inverse() * p_W).z());
    }
    EXPECT_NEAR(lowest_m, 2e-3, kRounding_m) << "the gap";
    EXPECT_LT((X_WE.inverse() * scene.object.X_WO.translation()).head<2>().norm(), 1e-12) << "below the centre of mass";
  }
}

// The support function of an ellipsoid with the half axes a is |a u|; that of its samples differs by what the samples
// stand for, which SampledSolid estimates itself.
TEST(StandingObject, AnEllipsoidTouchesWhereItsFormulaHasIt) {
  std::mt19937_64 random(7);
  Scene scene = scene_of("box_grasp", {"object.shape={ellipsoid: [50 mm, 60 mm, 40 mm]}", "object.points=6000"});
  std::vector<std::string> notes;
  const double error_m = SampledSolid(make_object_surface(scene, notes).cloud()).round_error_m();
  ASSERT_LT(error_m, 20e-6) << "samples that are good enough to tell";
  for (int i = 0; i < 5; ++i) {
    const Vector3d down = random_direction(random);
    const Isometry3d X_WE = stood_on(scene, "{shape: {plane: true}, under: object}", down);
    const Vector3d down_O = scene.object.X_WO.linear().transpose() * down;
    const double support_m = Vector3d(25e-3, 30e-3, 20e-3).cwiseProduct(down_O).norm();
    EXPECT_NEAR((X_WE.inverse() * scene.object.X_WO.translation()).z(), support_m, 2.0 * error_m + kRounding_m);
  }
}

// A box and a cylinder carry the object on their tops.
TEST(StandingObject, StandsOnTheTopOfABody) {
  const Scene scene = scene_of("box_grasp", {kCoarseBox});
  const Vector3d down = -scene.object.X_WO.linear().col(2);
  for (const char* shape : {"{box: [200 mm, 100 mm, 30 mm]}", "{cylinder: {radius: 60 mm, length: 30 mm}}"}) {
    const Isometry3d X_WE = stood_on(scene, fmt::format("{{shape: {}, under: object}}", shape), down);
    const Isometry3d X_OE = scene.object.X_WO.inverse() * X_WE;
    EXPECT_TRUE(X_OE.translation().isApprox(Vector3d(0.0, 0.0, -25e-3 - 15e-3), 1e-9)) << shape;
    EXPECT_TRUE(X_OE.linear().isIdentity(1e-9)) << "its axes are the object's";
  }
}

// Bodies, their moves and the goal are placed by the object, and gravity is turned by it.
TEST(StandingObject, WhatIsInTheObjectsFrameGoesWithIt) {
  const Scene scene = scene_of(
      "box_grasp",
      {kCoarseBox, "gravity={down: [1, 2, -2], magnitude: 3 m/s^2, frame: object}",
       "environment={frame: object, friction: 0.3, bodies: [{shape: {sphere: 3 mm}, position: [90 mm, 0 mm, 0 mm], "
       "rotation: {axis: [0, 1, 0], angle: 90 deg}, move: [{by: [0 mm, 5 mm, 0 mm], from: 0 s, over: 1 s}]}]}",
       "task={goal: {position: [0 mm, 0 mm, 7 mm], rotation: {axis: [1, 0, 0], angle: 90 deg}}}"});
  const Model model = build_model(scene);
  const Isometry3d& X_WO = scene.object.X_WO;
  EXPECT_TRUE(model.scene.gravity.isApprox(X_WO.linear() * Vector3d(1.0, 2.0, -2.0), 1e-12));
  const EnvironmentBody& body = model.scene.environment->bodies[0];
  EXPECT_TRUE(body.X_WE.translation().isApprox(X_WO * Vector3d(90e-3, 0.0, 0.0), 1e-12));
  EXPECT_TRUE((X_WO.linear().transpose() * body.X_WE.linear() * Vector3d::UnitZ()).isApprox(Vector3d::UnitX(), 1e-12));
  EXPECT_TRUE(body.moves[0].by_m.isApprox(5e-3 * X_WO.linear().col(1), 1e-12));
  EXPECT_TRUE(model.scene.task.goal->position_m->isApprox(X_WO * Vector3d(0.0, 0.0, 7e-3), 1e-12));
  EXPECT_TRUE((*model.scene.task.goal->rotation * Vector3d::UnitY()).isApprox(X_WO.linear().col(2), 1e-12));
  EXPECT_FALSE(model.scene.gravity_in_object_frame || model.scene.environment->in_object_frame) << "once";
}

TEST(StandingObject, RefusesWhatCannotStand) {
  const auto under = [](const std::string& body) { return "environment={friction: 0.3, bodies: [" + body + "]}"; };
  const std::string at = "environment.bodies[0].";
  EXPECT_EQ(
      fault_with("box_grasp", {"gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]", under("{shape: {plane: true}, under: object}")}),
      at + "under: needs gravity, which says where down is");
  EXPECT_EQ(fault_with("box_grasp", {under("{shape: {sphere: 9 mm}, under: object}")}),
            at + "under: is for a plane, a box or a cylinder, which have a level top");
  EXPECT_EQ(fault_with("box_grasp", {under("{shape: {plane: true}, under: object, position: [0 m, 0 m, 0 m]}")}),
            at + "position: follows from under: leave out one of them");
  EXPECT_EQ(fault_with("box_grasp", {under("{shape: {plane: true}, gap: 1 mm, position: [9 m, 0 m, 0 m]}")}),
            at + "gap: goes with under: object");
  EXPECT_EQ(fault_with("box_grasp", {under("{shape: {plane: true}, under: hand}")}).substr(0, 50),
            (at + "under: 'hand' is not one of object").substr(0, 50));
  EXPECT_EQ(fault_with("found_carry", {under("{shape: {plane: true}, under: object}")}).substr(0, 70),
            (at + "under: needs gravity in the object's frame, gravity: {down: [0, 0, -1]").substr(0, 70));
  EXPECT_EQ(fault_with("found_carry", {kUpright, under("{shape: {plane: true}, under: object}")}),
            at + "under: needs environment.frame: object where the grasp is found");
}

/// How deep the hand reaches into the environment of a model at its start.
double reach_m(const Model& model) {
  HandPose pose;
  forward_kinematics(model.scene.hand, model.scene.posture, pose);
  return hand_reach(*model.scene.environment, model.scene.hand, hand_body(model.scene.hand), pose,
                    model.scene.object.X_WO)
      .depth_m;
}

// The object stands upright on its table, the hand that is found for it stays out of the table, and lifts it off.
TEST(StandingObject, IsTakenOffItsTableByAGraspThatIsFound) {
  const Scene scene = scene_of("found_carry", {kUpright, kTable, "grasp={press: 1.2 N}", "time.duration=2 s",
                                               "object.damping={translation: 1 N*s/m, rotation: 0.0005 N*m*s}",
                                               "task={phases: [{lift: {by: [0 mm, 0 mm, 30 mm], over: 0.8 s}}]}"});
  const Model model = build_model(scene);
  const Isometry3d X_OE = model.scene.object.X_WO.inverse() * model.scene.environment->bodies[0].X_WE;
  EXPECT_NEAR(X_OE.translation().z(), -40e-3, kRounding_m) << "the cylinder stands on its end";
  EXPECT_TRUE(X_OE.linear().isIdentity(1e-9));
  EXPECT_TRUE(model.scene.gravity.isApprox(-9.81 * model.scene.object.X_WO.linear().col(2), 1e-12));
  EXPECT_LE(reach_m(model), 1e-3) << "but for what settling moves the fingers by";
  State state(model);
  const Recording result = run_scene(model, state);
  EXPECT_EQ(result.verdict.outcome, Outcome::kTaskDone) << in_words(result.verdict);
  EXPECT_TRUE(state.environment_forces.empty()) << "it has left the table";
}

// Without the table the same search finds hands that reach below it: the table is what keeps them out.
TEST(StandingObject, AHandThatWouldBeInTheTableIsNotFound) {
  const std::vector<std::string> changes{kUpright, "grasp={press: 1.2 N, approach: [0, 0, 1]}"};
  std::vector<std::string> with_table = changes;
  with_table.emplace_back(kTable);
  const std::string fault = fault_with("found_carry", with_table);
  EXPECT_NE(fault.find("'table' is in the hand's way"), std::string::npos) << fault;
  EXPECT_NE(fault.find("grasp.approach"), std::string::npos) << "what would help: " << fault;
  EXPECT_EQ(fault_with("found_carry", changes), "") << "from below, without a table";
}

}  // namespace
}  // namespace thenar::standing_object_test
