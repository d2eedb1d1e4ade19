// SPDX-License-Identifier: Apache-2.0
// Edges of meshes cost and give no energy either: over those of prisms, however blunt, chamfers, and the rims of holes.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "bench/cases/edge_ways.h"
#include "bench/cases/probe.h"
#include "tests/support/scratch.h"

namespace thenar::mesh_edges_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using namespace truth;

constexpr double kTurn = 2.0 * std::numbers::pi;

/// A prism along z over a polygon [mm] that the z axis goes through, as an OBJ file.
CloudShape prism(const std::string& name, const std::vector<Vector2d>& corners, double length_mm) {
  CloudShape shape;
  shape.file = scratch() / (name + ".obj");
  shape.unit_m = 1e-3;
  std::ofstream file(shape.file);
  const auto n = corners.size();
  for (const double z : {-0.5 * length_mm, 0.5 * length_mm}) {
    for (const Vector2d& c : corners) file << "v " << c.x() << ' ' << c.y() << ' ' << z << '\n';
  }
  file << "v 0 0 " << -0.5 * length_mm << "\nv 0 0 " << 0.5 * length_mm << '\n';
  for (std::size_t k = 1; k <= n; ++k) {
    const std::size_t next = k % n + 1;
    file << "f " << k << ' ' << next << ' ' << next + n << ' ' << k + n << '\n';
    file << "f " << 2 * n + 1 << ' ' << next << ' ' << k << "\nf " << 2 * n + 2 << ' ' << k + n << ' ' << next + n
         << '\n';
  }
  return shape;
}

std::vector<Vector2d> polygon(int corners, double inner_mm) {
  std::vector<Vector2d> all;
  for (int k = 0; k < corners; ++k) {
    const double angle = kTurn * (0.5 + static_cast<double>(k) / corners);
    all.emplace_back(inner_mm / std::cos(0.5 * kTurn / corners) * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return all;
}

/// A square plate of 50 mm, as thick as 20 mm, with a hole along z.
CloudShape holed_plate(double diameter_mm, int sides) {
  CloudShape shape;
  shape.file = scratch() / ("hole" + std::to_string(sides) + ".obj");
  shape.unit_m = 1e-3;
  std::ofstream file(shape.file);
  for (const double z : {-10.0, 10.0}) {
    for (const bool outside : {false, true}) {
      for (int k = 0; k < sides; ++k) {
        const Vector2d way(std::cos(kTurn * k / sides), std::sin(kTurn * k / sides));
        const Vector2d at = (outside ? 25.0 / way.cwiseAbs().maxCoeff() : 0.5 * diameter_mm) * way;
        file << "v " << at.x() << ' ' << at.y() << ' ' << z << '\n';
      }
    }
  }
  const auto corner = [&](int k, int outside, int top) { return 1 + k % sides + sides * (outside + 2 * top); };
  const auto quad = [&](int a, int b, int c, int d) { file << "f " << a << ' ' << b << ' ' << c << ' ' << d << '\n'; };
  for (int k = 0; k < sides; ++k) {
    quad(corner(k, 0, 1), corner(k, 1, 1), corner(k + 1, 1, 1), corner(k + 1, 0, 1));
    quad(corner(k, 0, 0), corner(k + 1, 0, 0), corner(k + 1, 1, 0), corner(k, 1, 0));
    quad(corner(k, 1, 0), corner(k + 1, 1, 0), corner(k + 1, 1, 1), corner(k, 1, 1));
    quad(corner(k, 0, 0), corner(k, 0, 1), corner(k + 1, 0, 1), corner(k + 1, 0, 0));
  }
  return shape;
}

/// 2 % are the bar of exact shapes; the step is that of 5 um.
void expect_one_energy(const EdgeWay& way, double depth_m, const Probe& probe = {}, double most = 0.02) {
  SCOPED_TRACE(way.name + ", " + std::to_string(1e3 * depth_m) + " mm");
  const Taken taken = take(way, depth_m, probe);
  EXPECT_LT(std::abs(taken.work_J), most * taken.stored_J);
  EXPECT_LT(taken.injected_J, most * taken.stored_J);
  EXPECT_LT(taken.step_N, most * taken.largest_N);
}

/// A pencil has six, chamfers and octagons 45 degrees; meshes are smooth over 20 degrees and less.
TEST(MeshEdges, HoweverBluntHaveOneEnergy) {
  for (const int corners : {5, 6, 7, 8, 10, 12, 16}) {
    const auto sides = polygon(corners, 12.0);
    const double to_edge_m = 1e-3 * sides[0].norm(), to_side_m = 12e-3;
    const CloudShape shape = prism("prism" + std::to_string(corners), sides, 60.0);
    const Matrix3d side_on = AngleAxisd(0.5 * kTurn / corners, Vector3d::UnitZ()).toRotationMatrix();
    const std::string name = std::to_string(corners) + " corners";
    for (const double depth_m : {0.3e-3, 0.8e-3, 2e-3}) {
      expect_one_energy({name, shape, Matrix3d::Identity(), {to_edge_m, -3e-3, 0.0}, {to_edge_m, 3e-3, 0.0}}, depth_m);
    }
    expect_one_energy({name + ", off the end", shape, side_on, {to_side_m, 0.2e-3, -20e-3}, {to_side_m, 1e-3, -34e-3}},
                      1e-3);
  }
}

TEST(MeshEdges, OfChamfersHaveOneEnergy) {
  const std::vector<Vector2d> plate = {{-20, -0.5}, {-19, -1.5}, {19, -1.5}, {20, -0.5},
                                       {20, 0.5},   {19, 1.5},   {-19, 1.5}, {-20, 0.5}};
  const CloudShape shape = prism("plate", plate, 40.0);
  const Matrix3d face_on = AngleAxisd(0.25 * kTurn, Vector3d::UnitZ()).toRotationMatrix();
  Probe probe;
  probe.points = 30000;
  for (const double depth_m : {0.3e-3, 1e-3}) {
    expect_one_energy({"across its rim", shape, Matrix3d::Identity(), {20e-3, -2.5e-3, 0}, {20e-3, 2.5e-3, 0}},
                      depth_m);
    expect_one_energy({"off its end", shape, face_on, {1.5e-3, 12e-3, 0}, {1.5e-3, 24e-3, 0}}, depth_m);
  }
}

/// The wall of a hole is hollow: the face around it ends there, though it goes on on both sides. A hole that is hardly
/// wider than the pulp is not one plane over a cell, and bends so much on the way that some of its samples are no face.
TEST(MeshEdges, OfHolesHaveOneEnergy) {
  const Matrix3d flat =
      (AngleAxisd(0.25 * kTurn, Vector3d::UnitY()) * AngleAxisd(0.3, Vector3d::UnitZ())).toRotationMatrix();
  for (const auto& [diameter_mm, sides] : {std::pair{20.0, 64}, std::pair{20.0, 360}, std::pair{10.0, 64}}) {
    const double rim_m = 0.5e-3 * diameter_mm;
    const EdgeWay way{"hole of " + std::to_string(diameter_mm) + " mm",
                      holed_plate(diameter_mm, sides),
                      flat,
                      {10e-3, rim_m + 7e-3, 0.0},
                      {10e-3, rim_m - 4e-3, 1e-3}};
    for (const double depth_m : {0.3e-3, 1e-3}) expect_one_energy(way, depth_m, {}, diameter_mm > 15.0 ? 0.02 : 0.15);
  }
}

}  // namespace
}  // namespace thenar::mesh_edges_test
