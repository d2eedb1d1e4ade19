// SPDX-License-Identifier: Apache-2.0
#include "engine/control/pose_loop.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/results/loop_words.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"

namespace thenar::pose_loop_test {
namespace {

/// A held box that is nudged, its pose known so late, with a gain of the position that is this share of its limit.
Scene nudged(int delay_ms, double share) {
  const std::string delay = std::to_string(delay_ms) + " ms";
  Scene scene = scene_of("box_load", {kCoarseBox, "control.feedback_delay=" + delay, "task.lost=20 mm",
                                      "task.push={force: [0.1 N, 0.1 N, 0.1 N], from: 0.8 s, over: 0.1 s}"});
  const Model model = build_model(scene);
  const PoseLoop loop(model);
  scene.control->position.p *= share * loop.most_gain(pose_gains(scene), loop.delay_steps(), PoseLoop::Of::kPosition);
  return scene;
}

Verdict verdict_of(const Scene& scene, const RunSettings& settings = {}) {
  const Model model = build_model(scene);
  State state(model);
  return run_scene(model, state, settings).verdict;
}

Scene late_scene(const std::string& name, const char* period, const char* delay) {
  return scene_of(name, {"object.points=6000", std::string("time.control_period=") + period,
                         std::string("time.control_delay=") + delay});
}

/// The verdict of a scene whose frames are late, in lockstep, after `time_s`.
Verdict late_verdict(Scene scene, double time_s) {
  scene.duration_s = time_s;
  RunSettings settings;
  settings.lockstep = LockstepSettings{};
  return verdict_of(scene, settings);
}

// The poles' limit is where runs begin to fail: a tenth below it the object rings and is held, a tenth above it is
// unstable, and the reason says so.
TEST(PoseLoop, SwingsWiderFromItsLimitOn) {
  for (const int ms : {65, 100}) {
    const Verdict below = verdict_of(nudged(ms, 0.9));
    EXPECT_EQ(in_words(below), "held") << ms;
    const Verdict above = verdict_of(nudged(ms, 1.1));
    EXPECT_EQ(above.outcome, Outcome::kUnstable) << in_words(above);
    EXPECT_NE(above.reason.find("pose loop does not stand its delay"), std::string::npos) << above.reason;
    EXPECT_NE(above.reason.find("swung about its target, wider each time"), std::string::npos) << above.reason;
  }
}

// What was lost because it swung is told as that, and when it was lost.
TEST(PoseLoop, WhatItThrowsAwayIsUnstable) {
  const Verdict verdict = verdict_of(nudged(65, 2.0));
  EXPECT_EQ(verdict.outcome, Outcome::kUnstable) << in_words(verdict);
  EXPECT_TRUE(verdict.lost_s.has_value());
}

/// Returns the largest eigenvalue of B^-1 K, K the P gains and B the viscosity of the object and of fingers that hold
/// it by rigid points, b (J J')^-1 at each.
double rigid_rate(const Model& model) {
  const Scene& scene = model.scene;
  const State start(model);
  HandPose pose;
  forward_kinematics(scene.hand, start.q, pose);
  Matrix6d B = Matrix6d::Zero(), K = Matrix6d::Zero();
  B.diagonal() << Eigen::Vector3d::Constant(scene.object.translation_damping),
      Eigen::Vector3d::Constant(scene.object.rotation_damping);
  K.diagonal() << Eigen::Vector3d::Constant(scene.control->position.p),
      Eigen::Vector3d::Constant(scene.control->rotation.p);
  for (int k = 0; k < model.fingers(); ++k) {
    const Eigen::Vector3d point_m = finger_contact(model, pose, start, k).point_m;
    const Eigen::Matrix3d JJ = squared(finger_jacobian(scene.hand, pose, k, point_m));
    Eigen::Matrix<double, 3, 6> at;
    at.leftCols<3>().setIdentity();
    for (int axis = 0; axis < 3; ++axis) {
      at.col(3 + axis) = Eigen::Vector3d::Unit(axis).cross(point_m - start.X_WO.translation());
    }
    B += scene.viscosity(k) * at.transpose() * JJ.ldlt().solve(at);
  }
  return Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d>(K, B, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

// Rigid fingertips without force control hold the object by points: x' = -k x(t - T) in each of its modes, whose limit
// is k T = pi/2. The bisection ends within 1 % below it.
TEST(PoseLoop, IsADelayedIntegratorOfRigidFingers) {
  Scene scene = scene_of("minimal");
  scene.control->position.i = scene.control->rotation.i = 0.0;
  scene.control->gain = 1e-3;
  const Model model = build_model(scene);
  const PoseLoop loop(model);
  for (const int delay : {50, 100}) {
    const double kT = loop.most_gain(pose_gains(scene), delay) * rigid_rate(model) * (delay + 0.5) * scene.step_s;
    EXPECT_NEAR(kT, std::numbers::pi / 2.0, 0.02 * std::numbers::pi / 2.0) << delay;
  }
}

// The spring that keeps the posture is a delayed integrator, too, of its stiffness over the joints' viscosity, 10 /s.
// It is the first to be unstable where the gains of the pose are small: at 2 sin(pi / (4 n + 2)) = 10 /s times a step.
TEST(PoseLoop, ThePosturesSpringLimitsSmallGains) {
  const Scene scene = scene_of("box_load", {kCoarseBox});
  const double share = *scene.control->posture_Nm_per_rad / scene.joint_viscosity * scene.step_s;
  int most = 0;
  while (2.0 * std::sin(std::numbers::pi / (4.0 * (most + 1) + 2.0)) > share) ++most;
  const Model model = build_model(scene);
  EXPECT_EQ(PoseLoop(model).most_delay(pose_gains(scene)), most);
}

// Frames of 5 ms, 20 ms late: the box is held, and its loop is near its limit but within it; the mug's is beyond.
TEST(PoseLoop, TellsTheBoxFromTheMug) {
  const Model box = build_model(late_scene("box_grasp", "5 ms", "20 ms"));
  const LoopMargin held = loop_margin(box, PoseLoop(box));
  EXPECT_LT(held.slowest.pole, 1.0);
  EXPECT_LT(held.share, 1.0);
  const Model mug = build_model(late_scene("mug", "5 ms", "20 ms"));
  const LoopMargin lost = loop_margin(mug, PoseLoop(mug));
  EXPECT_GT(lost.slowest.pole, 1.0);
  EXPECT_TRUE(lost.slowest.turns);
  EXPECT_LT(lost.most_delay, 20);
}

// A plate of 1 mm, whose forces' lever is as short: where a late loop runs away while the grip builds up, the loop is
// told first, then that no forces exist.
TEST(PoseLoop, ARunawayGripIsToldBeforeItsCones) {
  const Verdict verdict = late_verdict(late_scene("thin_plate", "2 ms", "2 ms"), 0.05);
  EXPECT_EQ(verdict.outcome, Outcome::kUnstable) << in_words(verdict);
  EXPECT_EQ(verdict.reason.find("while the grip built up, its loop ran away"), 0u) << verdict.reason;
  EXPECT_NE(verdict.reason.find("no grasp forces exist"), std::string::npos) << verdict.reason;
  EXPECT_EQ(in_words(late_verdict(late_scene("thin_plate", "2 ms", "0 ms"), 0.1)), "held");
}

// Each phase with gains of its own has a loop of its own.
TEST(PoseLoop, PhasesHaveTheirOwn) {
  const Model model = build_model(scene_of("peg_assembly"));
  const std::vector<LoopMargin> all = loop_margins(model);
  ASSERT_GE(all.size(), 2u);
  EXPECT_EQ(all.front().phase, -1);
  EXPECT_EQ(model.scene.task.phases[all[1].phase].kind, Phase::Kind::kInsert);
}

/// Whether swings of these sizes, one after the other, are told; about the axes or along one.
bool tells(const std::vector<double>& sizes, bool turns) {
  Swings swings;
  double way = 1.0;
  for (const double size : sizes) {
    for (int i = 0; i < 100; ++i) {
      const double off = size * std::sin(std::numbers::pi * i / 100.0);
      if (swings.add({0.0, turns ? 0.0 : way * off, 0.0}, turns ? std::abs(off) : 0.0)) return true;
    }
    way = -way;
  }
  return false;
}

std::vector<double> growing(double first, double factor, int count) {
  std::vector<double> sizes;
  for (int i = 0; i < count; ++i) sizes.push_back(first * std::pow(factor, i));
  return sizes;
}

// Growth is told, along an axis or about one; steady, dying and small swings are not, nor a beat, nor a ramp.
TEST(Swings, TellThoseThatGrow) {
  EXPECT_TRUE(tells(growing(0.2e-3, 1.15, 20), false));
  EXPECT_TRUE(tells(growing(5e-3, 1.15, 20), true));
  EXPECT_TRUE(tells(growing(0.1e-3, 3.0, 7), false));
  EXPECT_FALSE(tells(growing(0.2e-3, 1.0, 100), false));
  EXPECT_FALSE(tells(growing(5e-3, 0.95, 100), false));
  EXPECT_FALSE(tells(growing(1e-9, 1.15, 60), false));
  std::vector<double> beats;
  for (int i = 0; i < 100; ++i) beats.push_back(1e-3 * (1.0 + 0.3 * std::sin(i / 5.0)));
  EXPECT_FALSE(tells(beats, false));
  Swings ramp;
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(ramp.add({1e-5 * i, 0.0, 0.0}, 0.0).has_value());
}

}  // namespace
}  // namespace thenar::pose_loop_test
