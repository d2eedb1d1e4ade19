// SPDX-License-Identifier: Apache-2.0
// What samples say of edges: there are some where faces meet, however bluntly, and none on what is round.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "collision/implicit_surface.h"
#include "collision/triangle_mesh.h"

namespace thenar::sampled_edges_test {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Matrix3Xi;
using Eigen::Vector3d;

constexpr double kTurn = 2.0 * std::numbers::pi;

/// The side of a prism along z, or with many sides of a rod, without its ends.
TriangleMesh tube(int sides, double outer_m, double length_m) {
  TriangleMesh mesh{Matrix3Xd(3, 2 * sides), Matrix3Xi(3, 2 * sides)};
  for (int k = 0; k < sides; ++k) {
    const double angle = kTurn * k / sides;
    mesh.vertices_m.col(k) << outer_m * std::cos(angle), outer_m * std::sin(angle), -0.5 * length_m;
    mesh.vertices_m.col(k + sides) = mesh.vertices_m.col(k) + length_m * Vector3d::UnitZ();
    const int next = (k + 1) % sides;
    mesh.triangles.col(2 * k) << k, next, next + sides;
    mesh.triangles.col(2 * k + 1) << k, next + sides, k + sides;
  }
  return mesh;
}

Index with_edges(const ImplicitSurface& surface) {
  Index count = 0;
  for (Index i = 0; i < surface.cloud().points_m.cols(); ++i) count += surface.beside(i).empty() ? 0 : 1;
  return count;
}

TEST(SampledEdges, AreNoneOnWhatIsRound) {
  for (const double supports : {1.0, 1.5, 2.0, 3.0, 6.0}) {
    SCOPED_TRACE(supports);
    const ImplicitSurface rod(sample_mesh(tube(120, 4e-3, 40e-3), 4000), 4e-3 / supports);
    for (const double reach : {2.0, 3.0}) {
      ImplicitSurface looked = rod;
      looked.find_edges(reach * rod.support_m());
      EXPECT_EQ(with_edges(looked), 0) << reach;
    }
  }
}

/// Noise of 2 degrees is what is left of a scan's after its repair.
TEST(SampledEdges, AreNoneOnANoisyPlane) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 2.0 * kTurn / 360.0);
  PointCloud plane = sample_mesh(
      {(Matrix3Xd(3, 3) << 0, 40e-3, 0, 0, 0, 40e-3, 0, 0, 0).finished(), (Matrix3Xi(3, 1) << 0, 1, 2).finished()},
      4000);
  for (Index i = 0; i < plane.normals.cols(); ++i) {
    plane.normals.col(i) = (plane.normals.col(i) + Vector3d(noise(random), noise(random), 0.0)).normalized();
  }
  ImplicitSurface surface(plane);
  surface.find_edges(3.0 * surface.support_m());
  EXPECT_EQ(with_edges(surface), 0);
}

/// Every sample that is well within reach of an edge knows the face across it, as a plane that is that face's.
TEST(SampledEdges, AreWhereFacesMeetHoweverBluntly) {
  for (const int sides : {5, 8, 12, 16}) {
    SCOPED_TRACE(sides);
    ImplicitSurface surface(sample_mesh(tube(sides, 12e-3, 40e-3), 8000));
    const double reach_m = 3.0 * surface.support_m();
    surface.find_edges(reach_m);
    const PointCloud& cloud = surface.cloud();
    for (Index i = 0; i < cloud.points_m.cols(); ++i) {
      const Vector3d x_m = cloud.points_m.col(i), n = cloud.normals.col(i);
      const double angle = std::round(std::atan2(x_m.y(), x_m.x()) * sides / kTurn) * kTurn / sides;
      const Vector3d out(std::cos(angle), std::sin(angle), 0.0), over = 2.0 * out.dot(n) * out - n;
      if ((x_m - 12e-3 * out).head<2>().norm() > 0.8 * reach_m || std::abs(x_m.z()) > 15e-3) continue;
      double nearest = -1.0;
      for (const Index other : surface.beside(i)) {
        nearest = std::max(nearest, surface.face_distance(x_m, other).normal.dot(over));
      }
      EXPECT_GT(nearest, 1.0 - 1e-9) << x_m.transpose();
    }
    // On the way across an edge, distances go on evenly: by the way at most.
    const Vector3d edge = 12.3e-3 * Vector3d::UnitX();
    double last_m = surface.distance(edge - 3e-3 * Vector3d::UnitY(), 10e-3)->distance_m;
    for (double y_m = -3e-3; y_m < 3e-3; y_m += 10e-6) {
      const double d_m = surface.distance(edge + y_m * Vector3d::UnitY(), 10e-3)->distance_m;
      EXPECT_LT(std::abs(d_m - last_m), 20e-6) << y_m;
      last_m = d_m;
    }
  }
}

/// Sweeps lend a surface from row to row, which look for edges as far as their own pulps' cells reach.
TEST(SampledEdges, AreForgottenByTheNextLook) {
  const ImplicitSurface fresh(sample_mesh(tube(8, 12e-3, 40e-3), 4000));
  ImplicitSurface once = fresh, twice = fresh;
  once.find_edges(1.5 * fresh.support_m());
  twice.find_edges(4.0 * fresh.support_m());
  twice.find_edges(1.5 * fresh.support_m());
  for (Index i = 0; i < fresh.cloud().points_m.cols(); ++i) {
    ASSERT_TRUE(std::ranges::equal(once.beside(i), twice.beside(i))) << i;
    const Vector3d x_m = fresh.cloud().points_m.col(i) + 0.1e-3 * fresh.cloud().normals.col(i);
    ASSERT_EQ(once.face_distance(x_m, i).distance_m, twice.face_distance(x_m, i).distance_m) << i;
    ASSERT_EQ(once.bend(i).k1_per_m, twice.bend(i).k1_per_m) << i;
  }
}

}  // namespace
}  // namespace thenar::sampled_edges_test
