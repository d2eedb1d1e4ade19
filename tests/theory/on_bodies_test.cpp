// SPDX-License-Identifier: Apache-2.0
// What lies on bodies of the environment rests, rolls and is pushed as statics and kinematics have it, however its
// edges lie, and however fast bodies come.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include "bench/cases/scene_run.h"
#include "engine/scenes/scene_file.h"
#include "tests/support/scratch.h"

namespace thenar::on_bodies_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kWeight_N = 0.1 * 9.80665, kDegree = std::numbers::pi / 180.0;

std::string row(const Vector3d& v, const char* unit) {
  std::ostringstream text;
  text.precision(17);
  text << '[' << v[0] << unit << ", " << v[1] << unit << ", " << v[2] << unit << ']';
  return text.str();
}
std::string rows(const Matrix3d& R) {
  return '[' + row(R.row(0), "") + ", " + row(R.row(1), "") + ", " + row(R.row(2), "") + ']';
}

/// 100 g on bodies, and nothing else but a fingertip that is far away.
struct Lying {
  std::string shape, bodies;
  Vector3d position_m = Vector3d::Zero();
  Matrix3d R = Matrix3d::Identity();
  double friction = 0.8, translation_damping = 10.0, rotation_damping = 0.005;
};

Scene scene_of(const Lying& lying) {
  std::ostringstream text;
  text.precision(17);
  text << "name: lying\ntime: {duration: 60 s, step: 1 ms, control_period: 10 ms}\n"
       << "gravity: [0 m/s^2, 0 m/s^2, -9.80665 m/s^2]\n"
       << "hand: {slides: [{at: [1 m, 0 m, 1 m], along: [0, 0, 1], radius: 8 mm, force: 0 N}]}\n"
       << "object: {shape: " << lying.shape << ", points: 4000, mass: 100 g, position: " << row(lying.position_m, " m")
       << ", rotation: " << rows(lying.R) << ", damping: {translation: " << lying.translation_damping
       << " N*s/m, rotation: " << lying.rotation_damping << " N*m*s}}\n"
       << "contact: {friction: 0.8, band: 0.3 mm}\n"
       << "environment: {friction: " << lying.friction << ", bodies: [" << lying.bodies << "]}\n";
  const std::filesystem::path file = scratch() / "lying.yaml";
  std::ofstream(file) << text.str();
  return load_scene(file);
}

/// Rests from 1 s on: the force is the weight in every tick, and it goes by less than a nanometre a second.
void expect_rest(const Lying& lying) {
  Loop loop(scene_of(lying));
  loop.run(1.0);
  const Eigen::Isometry3d before = loop.state.X_WO;
  constexpr int kTicks = 4000;
  double off_N = 0.0;
  for (int i = 0; i < kTicks; ++i) off_N = std::max(off_N, std::abs(loop.tick().environment.wrench[2] - kWeight_N));
  EXPECT_LT(off_N, 1e-6 * kWeight_N);
  const double time_s = kTicks * loop.model.scene.step_s;
  EXPECT_LT((loop.state.X_WO.translation() - before.translation()).norm() / time_s, 1e-9);
  EXPECT_LT(AngleAxisd(before.linear().transpose() * loop.state.X_WO.linear()).angle() / time_s, 1e-7);
}

TEST(OnBodies, ABoxRestsOverATablesEdge) {
  for (const double yaw : {0.0, 5.0, 30.0, 45.0}) {
    for (const double inside_m : {1e-3, 5e-3}) {
      SCOPED_TRACE(std::to_string(yaw) + " degrees, " + std::to_string(1e3 * inside_m) + " mm inside");
      expect_rest({"{box: [60 mm, 40 mm, 40 mm]}",
                   "{shape: {box: [200 mm, 200 mm, 40 mm]}, position: [-100 mm, 0 mm, -20 mm]}",
                   {-inside_m, 0.0, 20e-3},
                   AngleAxisd(yaw * kDegree, Vector3d::UnitZ()).toRotationMatrix()});
    }
  }
}

TEST(OnBodies, ABarRestsAcrossABar) {
  for (const double yaw : {10.0, 30.0, 60.0, 90.0}) {
    SCOPED_TRACE(yaw);
    expect_rest({"{box: [100 mm, 20 mm, 20 mm]}",
                 "{shape: {box: [100 mm, 20 mm, 20 mm]}, position: [0 mm, 0 mm, 0 mm]}",
                 {3e-3, 2e-3, 20e-3},
                 AngleAxisd(yaw * kDegree, Vector3d::UnitZ()).toRotationMatrix()});
  }
}

// By 8 mm on either of two blocks: faces that look at one another sideways overlap by as much, and touch nothing.
TEST(OnBodies, APlankRestsOnTwoBlocks) {
  for (const double yaw : {0.0, 0.3}) {
    SCOPED_TRACE(yaw);
    expect_rest({"{box: [100 mm, 30 mm, 20 mm]}",
                 "{shape: {box: [40 mm, 40 mm, 40 mm]}, position: [-62 mm, 0 mm, -20 mm]}, "
                 "{shape: {box: [40 mm, 40 mm, 40 mm]}, position: [62 mm, 0 mm, -20 mm]}",
                 {0.0, 0.0, 10e-3},
                 AngleAxisd(yaw * kDegree, Vector3d::UnitZ()).toRotationMatrix()});
  }
}

// On a slope that friction holds it presses one side of its end more, and leans there by some 1e-5 rad: its lowest
// place bears with those beside it.
TEST(OnBodies, ACylinderRestsOnItsEnd) {
  for (const double degrees : {0.0, 5.0, 15.0}) {
    SCOPED_TRACE(degrees);
    const Matrix3d slope = AngleAxisd(degrees * kDegree, Vector3d::UnitY()).toRotationMatrix();
    expect_rest({"{cylinder: {radius: 25 mm, length: 60 mm}}",
                 "{shape: {plane: true}, position: [0 mm, 0 mm, 0 mm], rotation: " + rows(slope) + "}",
                 30e-3 * slope.col(2), slope});
  }
}

// A plate that passes beside a box by 0.1 mm leaves it where it is, but for what one tick takes its way for.
TEST(OnBodies, ABodyPassesBy) {
  for (const char* const shape : {"{box: [20 mm, 20 mm, 20 mm]}", "{sphere: 10 mm}"}) {
    SCOPED_TRACE(shape);
    const std::string bodies =
        "{shape: {plane: true}, position: [0 mm, 0 mm, 0 mm]}, {shape: {box: [2 mm, 100 mm, 30 mm]}, "
        "position: [-100 mm, 60.1 mm, 16 mm], move: [{by: [200 mm, 0 mm, 0 mm], from: 50 ms, over: 75 ms}]}";
    Loop loop(scene_of({shape, bodies, {0.0, 0.0, 10e-3}}));
    loop.run(0.2);
    EXPECT_LT(loop.state.X_WO.translation().head<2>().norm(), 2e-6);
  }
}

// Rolling: b_t v + b_r w / r = m g sin a, v = w r.
TEST(OnBodies, ACylinderRollsOnASlope) {
  constexpr double kRadius_m = 25e-3, kTranslation = 5.0, kRotation = 0.001;
  for (const double degrees : {0.5, 2.0, 5.0, 10.0, 20.0}) {
    SCOPED_TRACE(degrees);
    const Matrix3d slope = AngleAxisd(degrees * kDegree, Vector3d::UnitY()).toRotationMatrix();
    Lying lying{"{cylinder: {radius: 25 mm, length: 50 mm}}",
                "{shape: {plane: true}, position: [0 mm, 0 mm, 0 mm], rotation: " + rows(slope) + "}",
                kRadius_m * slope.col(2), slope * AngleAxisd(90.0 * kDegree, Vector3d::UnitX())};
    lying.translation_damping = kTranslation;
    lying.rotation_damping = kRotation;
    Loop loop(scene_of(lying));
    const double speed_m_per_s =
        kWeight_N * std::sin(degrees * kDegree) / (kTranslation + kRotation / (kRadius_m * kRadius_m));
    double worst = 0.0;
    for (int i = 0; i < 20; ++i) {
      loop.run(0.01);  // It starts at once.
      const Vector3d before = loop.state.X_WO.translation();
      loop.run(0.04);
      const double now_m_per_s = (loop.state.X_WO.translation() - before).norm() / 0.04;
      worst = std::max(worst, std::abs(now_m_per_s / speed_m_per_s - 1.0));
    }
    EXPECT_LT(worst, 0.01);
  }
}

// A plate goes 200 mm through where an object stands: it takes the object along.
TEST(OnBodies, NothingLetsAPlatePass) {
  for (const double thick_mm : {1.0, 2.0, 20.0}) {
    for (const double m_per_s : {0.5, 1.2, 5.0, 20.0}) {
      for (const char* const shape :
           {"{sphere: 10 mm}", "{box: [20 mm, 20 mm, 20 mm]}", "{cylinder: {radius: 10 mm, length: 20 mm}}",
            "{ellipsoid: [20 mm, 20 mm, 20 mm]}"}) {
        std::ostringstream bodies, trace;
        const double over_s = 1.875 * 0.2 / m_per_s;  // The fastest of a minimum-jerk way.
        bodies << "{shape: {plane: true}, position: [0 mm, 0 mm, 0 mm]}, {shape: {box: [" << thick_mm
               << " mm, 100 mm, 30 mm]}, position: [-100 mm, 0 mm, 16 mm], "
               << "move: [{by: [200 mm, 0 mm, 0 mm], from: 50 ms, over: " << over_s << " s}]}";
        trace << thick_mm << " mm at " << m_per_s << " m/s, " << shape;
        SCOPED_TRACE(trace.str());
        Lying lying{shape, bodies.str(), {0.0, 0.0, 10e-3 + 1e-6}};
        lying.friction = 0.3;
        lying.translation_damping = 2.0;
        Loop loop(scene_of(lying));
        loop.run(0.1 + over_s);
        EXPECT_NEAR(loop.state.X_WO.translation().x(), 0.11 + 0.5e-3 * thick_mm, 1e-3);
      }
    }
  }
}

}  // namespace
}  // namespace thenar::on_bodies_test
