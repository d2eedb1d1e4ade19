// SPDX-License-Identifier: Apache-2.0
// A pulp and a rigid object without friction are one energy: whatever way the object is taken over edges, corners and
// rims, the hand that moves it gets back what it gave. And forces at edges are those of an elastic half space.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "bench/cases/edge_ways.h"
#include "bench/cases/probe.h"

namespace thenar::edges_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using namespace truth;

class Edges : public testing::TestWithParam<EdgeWay> {};

TEST_P(Edges, GiveBackWhatTheyTake) {
  for (const double depth_m : {0.3e-3, 1e-3, 3e-3}) {
    SCOPED_TRACE(depth_m);
    const Taken taken = take(GetParam(), depth_m, {});
    EXPECT_LT(std::abs(taken.work_J), 0.02 * taken.stored_J);
    // The ledger, too, sees nothing from nowhere.
    EXPECT_LT(taken.injected_J + taken.dissipated_J, 1e-3 * taken.stored_J);
    EXPECT_LT(taken.step_N, (GetParam().is_pointed ? 0.05 : 0.02) * taken.largest_N);
  }
}

TEST_P(Edges, LetAPadThatRubsGoOnEvenly) {
  Probe probe;
  probe.friction = 0.8;
  for (const double depth_m : {0.3e-3, 1e-3, 3e-3}) {
    SCOPED_TRACE(depth_m);
    const Taken taken = take(GetParam(), depth_m, probe);
    EXPECT_GT(taken.work_J, 0.0);
    // A pulp that friction has wound by 3 mm leaves a cylinder's rim less evenly.
    const double most = GetParam().is_pointed ? 0.05 : depth_m > 2e-3 ? 0.035 : 0.02;
    EXPECT_LT(taken.step_N, most * taken.largest_N);
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, Edges, testing::ValuesIn(edge_ways()), [](const auto& way) { return way.param.name; });

TEST(Edges, OfFourTimesThePointsGiveBackAsMuch) {
  Probe probe;
  probe.leaves = 1280;
  for (const EdgeWay& way : edge_ways()) {
    SCOPED_TRACE(way.name);
    const Taken taken = take(way, 1e-3, probe);
    EXPECT_LT(std::abs(taken.work_J), 0.02 * taken.stored_J);
    EXPECT_LT(taken.step_N, 0.02 * taken.largest_N);
  }
}

/// How points give way for one another is as if their cells were whole; their own parts are what counts.
TEST(Edges, OfSoftObjectsGiveBackNearlyAsMuch) {
  Probe probe;
  probe.object_modulus_Pa = 1e6;
  for (const EdgeWay& way : edge_ways()) {
    for (const double depth_m : {0.3e-3, 1e-3, 3e-3}) {
      SCOPED_TRACE(way.name + " " + std::to_string(depth_m));
      const Taken taken = take(way, depth_m, probe);
      EXPECT_LT(std::abs(taken.work_J), (depth_m < 2e-3 ? 0.04 : 0.06) * taken.stored_J);
      EXPECT_LT(taken.stored_J, taken.largest_N * depth_m);
      EXPECT_LT(taken.step_N, (way.is_pointed ? 0.05 : 0.02) * taken.largest_N);
    }
  }
}

TEST(Edges, OfEllipsoidPulpsGiveBackAsMuch) {
  Probe probe;
  probe.half_m = Vector3d(8e-3, 12e-3, 10e-3);
  for (const EdgeWay& way : edge_ways()) {
    for (const double depth_m : {1e-3, 3e-3}) {
      SCOPED_TRACE(way.name + " " + std::to_string(depth_m));
      const Taken taken = take(way, depth_m, probe);
      EXPECT_LT(std::abs(taken.work_J), 0.02 * taken.stored_J);
      EXPECT_LT(taken.step_N, (way.is_pointed ? 0.05 : 0.02) * taken.largest_N);
    }
  }
}

/// Under a frame a cell keeps its part and its slopes: at 20 ms for a way of 0.1 mm, a sixteenth of the cell.
TEST(Edges, OfLateFramesHoldByHowLateTheyAre) {
  for (const double frame_s : {5e-3, 20e-3}) {
    Probe probe;
    probe.frame_s = frame_s;
    for (const EdgeWay& way : edge_ways()) {
      SCOPED_TRACE(way.name + " " + std::to_string(frame_s));
      // Where an edge points at a pulp that it hardly presses, its part of a cell changes the most.
      for (const double depth_m : {0.3e-3, 1e-3}) {
        const Taken taken = take(way, depth_m, probe);
        EXPECT_LT(std::abs(taken.work_J), (frame_s < 10e-3 ? 0.025 : depth_m < 1e-3 ? 0.12 : 0.08) * taken.stored_J);
      }
    }
  }
}

/// The force at a depth.
Vector3d pressed_N(const Shape& shape, const Matrix3d& R, const Vector3d& touches_m, double depth_m, Index leaves) {
  constexpr double kClear_m = 0.2e-3;
  Probe probe;
  probe.shape = shape;
  probe.points = 12000;
  probe.leaves = leaves;
  const Vector3d towards = touches_m.normalized();
  probe.X_WO.linear() = R;
  probe.X_WO.translation() = touches_m + kClear_m * towards;
  Loop loop(scene_of(probe));
  for (double way_m = -kClear_m; way_m < depth_m + 1e-9; way_m += 20e-6) {
    TickInput input;
    input.X_WT = probe.X_WO;
    input.X_WT->translation() = touches_m - std::min(way_m, depth_m) * towards;
    loop.tick(input);
  }
  TickInput input;
  input.X_WT = probe.X_WO;
  input.X_WT->translation() = touches_m - depth_m * towards;
  for (int k = 0; k < 3; ++k) loop.tick(input);
  return loop.state.load[0].force_N;
}

/// Bars across the pulp at 1 mm bear what the same kernel has with points ever closer: 0.75, 0.89, 0.91 N (a half space
/// with 5120 points a sphere). Lines along the normals of the pulp make them wider by d sin(angle): 13 % for 2 mm.
TEST(Edges, OfBarsBearWhatAHalfSpaceDoes) {
  const std::vector<std::pair<double, double>> bars = {{2e-3, 0.75}, {4e-3, 0.89}, {10e-3, 0.91}};
  for (const auto& [width_m, force_N] : bars) {
    SCOPED_TRACE(width_m);
    const BoxShape bar{Vector3d(width_m, width_m, 40e-3)};
    const Vector3d at_m(kProbeRadius_m + 0.5 * width_m, 0.3e-3, 0.4e-3);
    const double fine_N = pressed_N(bar, Matrix3d::Identity(), at_m, 1e-3, 1280).x();
    EXPECT_GT(fine_N, 0.98 * force_N);
    EXPECT_LT(fine_N, 1.14 * force_N);
    EXPECT_NEAR(pressed_N(bar, Matrix3d::Identity(), at_m, 1e-3, 320).x(), fine_N, 0.08 * fine_N);
  }
}

/// A cube's corner against the pulp, from anywhere. The same half space has 0.037 N at 0.5 mm: its sections are
/// triangles, and a cone through its edges, 0.054 N, is half as large again. Without friction its force is along its
/// axis but for what the places of points do.
TEST(Edges, OfACornerBearAConesForceWhereverItComes) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const Matrix3d corner = Eigen::Quaterniond::FromTwoVectors(Vector3d::Ones(), Vector3d::UnitX()).toRotationMatrix();
  for (const auto& [leaves, orientations, aside] :
       {std::tuple{Index{320}, 50, 0.25}, std::tuple{Index{1280}, 12, 0.16}}) {
    SCOPED_TRACE(leaves);
    double along_N = 0.0, across = 0.0;
    for (int k = 0; k < orientations; ++k) {
      const Vector3d turn = 0.35 * Vector3d(normal(random), normal(random), normal(random));
      const Matrix3d R = AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
      const Vector3d axis = R * Vector3d::UnitX();
      const Matrix3d spin = AngleAxisd(std::numbers::pi * normal(random), axis).toRotationMatrix();
      const Vector3d touches_m = (kProbeRadius_m + 5e-3 * std::sqrt(3.0)) * axis;
      const Vector3d F_N = pressed_N(BoxShape{Vector3d::Constant(10e-3)}, spin * R * corner, touches_m, 0.5e-3, leaves);
      along_N += F_N.dot(axis) / orientations;
      across += (F_N - F_N.dot(axis) * axis).norm() / F_N.dot(axis) / orientations;
    }
    EXPECT_NEAR(along_N, 0.037, 0.2 * 0.037);
    EXPECT_LT(across, aside);
  }
}

}  // namespace
}  // namespace thenar::edges_test
