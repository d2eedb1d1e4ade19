// SPDX-License-Identifier: Apache-2.0
// Rigid fingertips on a solid with a formula hold what Coulomb's law lets them hold, and no more: however coarse the
// samples, and in whichever direction the load acts.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "bench/cases/scene_run.h"
#include "engine/scenes/scene_file.h"
#include "tests/support/scratch.h"

namespace thenar::least_friction_test {
namespace {

using Eigen::Vector3d;

constexpr double kPress_N = 2.0, kDegree = std::numbers::pi / 180.0;

/// Rigid tips of 8 mm on slides, each pressed with a force on a shape at the world's origin, which has few samples.
struct Tips {
  std::string shape;
  std::vector<Vector3d> at_m;  ///< Where each touches.
  std::vector<Vector3d> inward;
  std::vector<double> press_N;
};

std::string row(const Vector3d& v, const char* unit) {
  std::ostringstream text;
  text.precision(17);
  text << '[' << v[0] << unit << ", " << v[1] << unit << ", " << v[2] << unit << ']';
  return text.str();
}

Scene scene_of(const Tips& tips, double friction) {
  constexpr double kTip_m = 8e-3;
  std::ostringstream text;
  text.precision(17);
  text << "name: tips\ntime: {duration: 2 s, step: 1 ms, control_period: 1 ms}\ngravity: [0 m/s^2, 0 m/s^2, 0 m/s^2]\n"
       << "hand:\n  slides:\n";
  for (std::size_t k = 0; k < tips.at_m.size(); ++k) {
    text << "    - {at: " << row(tips.at_m[k] - kTip_m * tips.inward[k], " m") << ", along: " << row(tips.inward[k], "")
         << ", radius: 8 mm, force: " << tips.press_N[k] << " N}\n";
  }
  text << "object: {shape: " << tips.shape << ", points: 2000, mass: 100 g, position: [0 m, 0 m, 0 m], "
       << "rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], damping: {translation: 10 N*s/m, rotation: 1e-3 N*m*s}}\n"
       << "contact: {friction: " << friction << ", band: 0.3 mm, tolerance: 1e-9, max_sweeps: 1000}\n";
  const std::filesystem::path file = scratch() / "tips.yaml";
  std::ofstream(file) << text.str();
  return load_scene(file);
}

Tips tips_round(const std::string& shape, double radius_m) {
  Tips tips{shape, {}, {}, {kPress_N, kPress_N, kPress_N}};
  for (int k = 0; k < 3; ++k) {
    const double angle = 2.0 * std::numbers::pi / 3.0 * k;
    tips.inward.emplace_back(-std::cos(angle), -std::sin(angle), 0.0);
    tips.at_m.push_back(-radius_m * tips.inward.back());
  }
  return tips;
}

/// One tip against two, across a box of 40 mm.
Tips tips_across() {
  const Vector3d x = Vector3d::UnitX();
  return {"{box: [40 mm, 40 mm, 40 mm]}",
          {{-20e-3, 0.0, 0.0}, {20e-3, 0.0, 10e-3}, {20e-3, 0.0, -10e-3}},
          {x, -x, -x},
          {kPress_N, 0.5 * kPress_N, 0.5 * kPress_N}};
}

/// How far the object's centre or its surface, `lever_m` off, has gone in the second after the load came to be there.
double moved_m(const Tips& tips, double friction, const Vector6d& load, double lever_m) {
  Loop loop(scene_of(tips, friction));
  loop.run(0.2);
  const Eigen::Isometry3d start = loop.state.X_WO;
  for (int i = 0; i < 1000; ++i) {
    TickInput input;
    input.wrench = load;
    loop.tick(input);
  }
  const double turn = Eigen::AngleAxisd(start.linear().transpose() * loop.state.X_WO.linear()).angle();
  return (loop.state.X_WO.translation() - start.translation()).norm() + lever_m * turn;
}

Vector6d force(const Vector3d& f_N) {
  Vector6d load = Vector6d::Zero();
  load.head<3>() = f_N;
  return load;
}
Vector6d moment(const Vector3d& m_Nm) {
  Vector6d load = Vector6d::Zero();
  load.tail<3>() = m_Nm;
  return load;
}

/// With 0.3 % more friction than the least it rests, with 0.3 % less it does not: what is left moves it by a micrometre
/// in some milliseconds.
void expect_least(const Tips& tips, double least, const Vector6d& load, double lever_m) {
  EXPECT_LT(moved_m(tips, 1.003 * least, load, lever_m), 20e-6);
  EXPECT_GT(moved_m(tips, 0.997 * least, load, lever_m), 100e-6);
}

std::string rod(double radius_m) {
  std::ostringstream text;
  text << "{cylinder: {radius: " << radius_m << " m, length: 60 mm}}";
  return text.str();
}

TEST(LeastFriction, OfARodAlongIt) {
  for (const double radius_m : {4e-3, 12e-3}) {
    SCOPED_TRACE(radius_m);
    expect_least(tips_round(rod(radius_m), radius_m), 0.4, force({0.0, 0.0, -0.4 * 3.0 * kPress_N}), radius_m);
  }
}

TEST(LeastFriction, OfARodAroundIt) {
  for (const double radius_m : {4e-3, 12e-3}) {
    SCOPED_TRACE(radius_m);
    expect_least(tips_round(rod(radius_m), radius_m), 0.4, moment({0.0, 0.0, 0.4 * 3.0 * kPress_N * radius_m}),
                 radius_m);
  }
}

TEST(LeastFriction, OfARodThatIsTurnedAndPulled) {
  constexpr double kRadius_m = 4e-3, kLoad_N = 0.4 * 3.0 * kPress_N;
  for (const double degrees : {22.5, 45.0}) {
    SCOPED_TRACE(degrees);
    Vector6d load = force({0.0, 0.0, -kLoad_N * std::cos(degrees * kDegree)});
    load[5] = kLoad_N * std::sin(degrees * kDegree) * kRadius_m;
    expect_least(tips_round(rod(kRadius_m), kRadius_m), 0.4, load, kRadius_m);
  }
}

TEST(LeastFriction, OfABall) {
  expect_least(tips_round("{sphere: 25 mm}", 25e-3), 0.5, force({0.0, 0.0, -0.5 * 3.0 * kPress_N}), 25e-3);
}

TEST(LeastFriction, OfAnEllipsoid) {
  // Its middle section is a circle, and the normals there are radial.
  expect_least(tips_round("{ellipsoid: [24 mm, 24 mm, 60 mm]}", 12e-3), 0.5, force({0.0, 0.0, -0.5 * 3.0 * kPress_N}),
               12e-3);
}

TEST(LeastFriction, OfABoxInAnyDirectionOfItsFaces) {
  for (const double degrees : {0.0, 22.5, 45.0, 90.0}) {
    SCOPED_TRACE(degrees);
    const Vector3d along(0.0, std::cos(degrees * kDegree), std::sin(degrees * kDegree));
    expect_least(tips_across(), 0.5, force(0.5 * 2.0 * kPress_N * along), 0.0);
  }
}

TEST(LeastFriction, APointHasNoSpin) {
  Loop loop(scene_of(tips_across(), 0.5));
  double spin_rad = 0.0;
  for (int i = 0; i < 500; ++i) {
    const TickReport report = loop.tick();
    for (int k = 0; k < loop.model.fingers(); ++k) spin_rad += std::abs(report.patch[k].spin_rad);
  }
  EXPECT_EQ(spin_rad, 0.0);
}

}  // namespace
}  // namespace thenar::least_friction_test
