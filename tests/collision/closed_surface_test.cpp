// SPDX-License-Identifier: Apache-2.0
#include "collision/closed_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "collision/shapes.h"

namespace thenar::closed_surface_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

double volume_m3(const TriangleMesh& mesh) {
  double volume = 0.0;
  for (const auto& t : mesh.triangles.colwise()) {
    const Vector3d a = mesh.vertices_m.col(t[0]), b = mesh.vertices_m.col(t[1]), c = mesh.vertices_m.col(t[2]);
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

/// How often a way along an edge is gone more often than the way back: 0, the triangles enclose something.
int open_edges(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> ways;
  for (const auto& t : mesh.triangles.colwise()) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      ways[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  int open = 0;
  for (const auto& [edge, more] : ways) open += more != 0 ? 1 : 0;
  return open;
}

struct Shape {
  std::string name;
  PointCloud cloud;
  double volume_m3;
};

std::vector<Shape> shapes() {
  Mug mug{0.04, 0.09, 0.004, {}};
  const double cup_m3 = std::numbers::pi * (0.04 * 0.04 * 0.09 - 0.036 * 0.036 * 0.086);
  return {{"box", sample_box({0.05, 0.06, 0.07}, 8000), 0.05 * 0.06 * 0.07},
          {"sphere", sample_sphere(0.03, 8000), 4.0 / 3.0 * std::numbers::pi * 2.7e-5},
          {"cylinder", sample_cylinder(0.03, 0.1, 8000), std::numbers::pi * 0.03 * 0.03 * 0.1},
          {"plate of 3 mm", sample_box({0.08, 0.06, 0.003}, 8000), 0.08 * 0.06 * 0.003},
          {"plate of 1 mm", sample_box({0.08, 0.06, 0.001}, 8000), 0.08 * 0.06 * 0.001},
          {"mug", sample_mug(mug, 20000), cup_m3}};
}

// Triangles whose vertices lie on a curved surface enclose less than it by the square of their size over its radius,
// 0.1 % here. An edge that were off by a quarter of a spacing, 0.3 mm, all around the plates would change what they
// enclose by 2 %.
TEST(ClosedSurface, EnclosesWhatTheSolidDoes) {
  for (const Shape& shape : shapes()) {
    SCOPED_TRACE(shape.name);
    const std::optional<TriangleMesh> mesh = closed_surface(ImplicitSurface(shape.cloud));
    ASSERT_TRUE(mesh);
    EXPECT_EQ(open_edges(*mesh), 0);
    EXPECT_NEAR(volume_m3(*mesh) / shape.volume_m3, 1.0, 0.01);
  }
}

// Samples lie on the two faces of an edge, none on the edge itself: the triangles must find it, within a quarter of a
// spacing.
TEST(ClosedSurface, HasTheEdgesOfABox) {
  const Vector3d half_m(0.025, 0.03, 0.035);
  const ImplicitSurface surface(sample_box(2.0 * half_m, 8000));
  const double spacing_m = surface.support_m() / 2.2, tolerance_m = 0.25 * spacing_m;
  const std::optional<TriangleMesh> mesh = closed_surface(surface);
  ASSERT_TRUE(mesh);
  Index on_edges = 0;
  for (const auto& x_m : mesh->vertices_m.colwise()) {
    const Vector3d off_m = x_m.cwiseAbs() - half_m;
    EXPECT_LT(std::abs(off_m.maxCoeff()), tolerance_m);
    on_edges += (off_m.array().abs() < tolerance_m).count() >= 2 ? 1 : 0;
  }
  // A cell, of 1.5 spacings or more, has one vertex: along 720 mm of edges there are so many, but for a few.
  EXPECT_GT(static_cast<double>(on_edges), 0.9 * 0.72 / (2.0 * spacing_m));
  // Every triangle lies in a face: the three corners share a side of the box.
  Index askew = 0;
  for (const auto& t : mesh->triangles.colwise()) {
    Eigen::Array3i sides = Eigen::Array3i::Zero();
    for (int k = 0; k < 3; ++k) {
      const Vector3d x_m = mesh->vertices_m.col(t[k]);
      for (int i = 0; i < 3; ++i) {
        if (std::abs(std::abs(x_m[i]) - half_m[i]) < tolerance_m) sides[i] += x_m[i] > 0.0 ? 1 : -1;
      }
    }
    askew += sides.abs().maxCoeff() < 3 ? 1 : 0;
  }
  EXPECT_EQ(askew, 0) << "of " << mesh->triangles.cols();
}

// The plane around a hole of 8 mm goes on over it, as the fingers feel it.
TEST(ClosedSurface, BridgesHoles) {
  const PointCloud whole = sample_box({0.04, 0.04, 0.04}, 20000);
  std::vector<Index> kept;
  for (Index i = 0; i < whole.points_m.cols(); ++i) {
    if ((whole.points_m.col(i) - Vector3d(0.02, 0.0, 0.0)).norm() > 0.004) kept.push_back(i);
  }
  const PointCloud holed{whole.points_m(Eigen::all, kept), whole.normals(Eigen::all, kept)};
  const std::optional<TriangleMesh> mesh = closed_surface(ImplicitSurface(holed));
  ASSERT_TRUE(mesh);
  EXPECT_EQ(open_edges(*mesh), 0);
  EXPECT_NEAR(volume_m3(*mesh) / 6.4e-5, 1.0, 0.01);
}

TEST(ClosedSurface, IsTheSameEachTime) {
  const ImplicitSurface surface(sample_sphere(0.02, 2000));
  const std::optional<TriangleMesh> one = closed_surface(surface), other = closed_surface(surface);
  ASSERT_TRUE(one && other);
  EXPECT_EQ(one->vertices_m, other->vertices_m);
  EXPECT_EQ(one->triangles, other->triangles);
}

// Half of a sphere, and fewer points than a grid could have.
TEST(ClosedSurface, ThereIsNoneWhereItCannotBeClosed) {
  const PointCloud whole = sample_sphere(0.03, 4000);
  std::vector<Index> upper;
  for (Index i = 0; i < whole.points_m.cols(); ++i) {
    if (whole.points_m(2, i) > 0.0) upper.push_back(i);
  }
  const PointCloud half{whole.points_m(Eigen::all, upper), whole.normals(Eigen::all, upper)};
  EXPECT_FALSE(closed_surface(ImplicitSurface(half)));
  EXPECT_FALSE(closed_surface(ImplicitSurface(sample_box({0.05, 0.06, 0.07}, 10))));
}

}  // namespace
}  // namespace thenar::closed_surface_test
