// SPDX-License-Identifier: Apache-2.0
#include "collision/triangle_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

namespace thenar::triangle_mesh_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::Vector3i;

/// A box of these sizes about `centre`, counter-clockwise from outside.
TriangleMesh box(const Vector3d& size_m, const Vector3d& centre_m = Vector3d::Zero()) {
  TriangleMesh mesh{Eigen::Matrix3Xd(3, 8), Eigen::Matrix3Xi(3, 12)};
  for (int i = 0; i < 8; ++i) {
    const Vector3d corner((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2 & 1) - 0.5);
    mesh.vertices_m.col(i) = centre_m + corner.cwiseProduct(size_m);
  }
  mesh.triangles.transpose() << 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3,
      1, 4, 5, 7, 4, 7, 6;
  return mesh;
}

TriangleMesh together(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh both{Eigen::Matrix3Xd(3, a.vertices_m.cols() + b.vertices_m.cols()),
                    Eigen::Matrix3Xi(3, a.triangles.cols() + b.triangles.cols())};
  both.vertices_m << a.vertices_m, b.vertices_m;
  both.triangles << a.triangles, (b.triangles.array() + static_cast<int>(a.vertices_m.cols())).matrix();
  return both;
}

TriangleMesh inside_out(TriangleMesh mesh) {
  mesh.triangles.row(1).swap(mesh.triangles.row(2));
  return mesh;
}

double volume_m3(const TriangleMesh& mesh) {
  double volume = 0.0;
  for (const auto& t : mesh.triangles.colwise()) {
    const Vector3d a = mesh.vertices_m.col(t[0]), b = mesh.vertices_m.col(t[1]), c = mesh.vertices_m.col(t[2]);
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

TEST(TriangleMesh, ASoundMeshStaysAsItIs) {
  const TriangleMesh sound = box({1, 2, 3});
  TriangleMesh mesh = sound;
  const MeshMending mending = mend(mesh);
  EXPECT_EQ(mesh.triangles, sound.triangles);
  EXPECT_EQ(mending.turned + mending.dropped + mending.open_edges + mending.at_odds, 0);
  EXPECT_EQ(mending.edges, 18);  // Euler: 8 - 18 + 12 = 2
  EXPECT_NEAR(volume_m3(mesh), 6.0, 1e-14);
}

TEST(TriangleMesh, TurnsTrianglesLikeTheirNeighbours) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 100; ++trial) {
    TriangleMesh mesh = box({1, 2, 3}, {5, 0, 0});
    const unsigned pattern = random() % 4096;
    for (int i = 0; i < 12; ++i) {
      if ((pattern >> i & 1) != 0) std::swap(mesh.triangles(0, i), mesh.triangles(1, i));
    }
    const MeshMending mending = mend(mesh);
    // A majority that is inside out is told by the volume.
    EXPECT_NEAR(volume_m3(mesh), 6.0, 1e-13);
    EXPECT_EQ(mending.at_odds, 0);
  }
}

TEST(TriangleMesh, JoinsVerticesAndDropsTrianglesWithoutArea) {
  // As in an STL file: every triangle has vertices of its own, and one is a needle.
  const TriangleMesh sound = box({1, 2, 3});
  TriangleMesh loose{Eigen::Matrix3Xd(3, 39), Eigen::Matrix3Xi(3, 13)};
  for (int i = 0; i < 36; ++i) loose.vertices_m.col(i) = sound.vertices_m.col(sound.triangles(i % 3, i / 3));
  loose.vertices_m.rightCols<3>() << loose.vertices_m.col(0), loose.vertices_m.col(1), loose.vertices_m.col(1);
  for (int i = 0; i < 39; ++i) loose.triangles(i % 3, i / 3) = i;
  const MeshMending mending = mend(loose);
  EXPECT_EQ(mending.dropped, 1);
  EXPECT_EQ(mending.edges, 18);
  EXPECT_EQ(mending.open_edges, 0);
  EXPECT_EQ(loose.triangles.cols(), 12);
}

TEST(TriangleMesh, TellsACavityFromAPartThatIsInsideOut) {
  const TriangleMesh outer = box({2, 2, 2}), within = box({1, 1, 1}), beside = box({1, 1, 1}, {5, 0, 0});
  for (const bool reversed : {false, true}) {
    const auto maybe = [&](const TriangleMesh& mesh) { return reversed ? inside_out(mesh) : mesh; };
    TriangleMesh hollow = maybe(together(outer, inside_out(within)));
    EXPECT_EQ(mend(hollow).turned, reversed ? 24 : 0);
    EXPECT_NEAR(volume_m3(hollow), 7.0, 1e-13);
    TriangleMesh two = maybe(together(outer, inside_out(beside)));
    EXPECT_EQ(mend(two).turned, 12);
    EXPECT_NEAR(volume_m3(two), 9.0, 1e-12);
  }
}

TEST(TriangleMesh, CountsOpenEdgesAndEdgesAtOdds) {
  TriangleMesh open = box({1, 2, 3});
  open.triangles.conservativeResize(3, 11);
  EXPECT_EQ(mend(open).open_edges, 3);
  // A Moebius strip of six triangles: whichever way they are wound, along one edge two cannot agree.
  TriangleMesh strip{Eigen::Matrix3Xd(3, 6), Eigen::Matrix3Xi(3, 6)};
  for (int i = 0; i < 6; ++i) {
    const double angle = std::numbers::pi * i / 1.5;
    const Vector3d out(std::cos(angle), std::sin(angle), 0.0);
    strip.vertices_m.col(i) = 3.0 * out + (i % 2 == 0 ? 1.0 : -1.0) * Vector3d(0.1 * i, 0.2, 1.0);
    strip.triangles.col(i) = i % 2 == 0 ? Vector3i(i, (i + 1) % 6, (i + 2) % 6) : Vector3i((i + 1) % 6, i, (i + 2) % 6);
  }
  // With an even number of corners the band has two sides; five make it a Moebius strip.
  strip.triangles.conservativeResize(3, 5);
  for (int i = 0; i < 5; ++i) strip.triangles.col(i) = Vector3i(i, (i + 1) % 5, (i + 2) % 5);
  EXPECT_EQ(mend(strip).at_odds, 1);
}

TEST(TriangleMesh, AnyTrianglesKeepTheirCorners) {
  // Few corners, many of them in one plane, so that faces lie on one another in every way.
  constexpr int kCorners = 7;
  for (unsigned seed = 1; seed <= 3000; ++seed) {
    std::mt19937 random(seed);
    TriangleMesh mesh{Eigen::Matrix3Xd(3, kCorners), Eigen::Matrix3Xi(3, 4 + seed % 12)};
    for (int i = 0; i < kCorners; ++i) mesh.vertices_m.col(i) << i % 3, i / 3 % 2, i / 6;
    for (int& corner : mesh.triangles.reshaped()) corner = static_cast<int>(random() % kCorners);
    (void)mend(mesh);
    for (const int corner : mesh.triangles.reshaped()) {
      ASSERT_TRUE(corner >= 0 && corner < mesh.vertices_m.cols()) << "seed " << seed << ", corner " << corner;
    }
  }
}

TEST(TriangleMesh, CutsPolygonsThatAreNotConvex) {
  // A star of ten corners in a slanted plane, and a comb whose teeth hide each other.
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.0, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  Eigen::Matrix3Xd star(3, 10), comb(3, 22);
  for (int i = 0; i < 10; ++i) {
    const double angle = 0.2 * std::numbers::pi * i, r = i % 2 == 0 ? 2.0 : 0.5;
    star.col(i) = R * Vector3d(r * std::cos(angle), r * std::sin(angle), 0.3);
  }
  for (int i = 0; i < 20; ++i) comb.col(i) = R * Vector3d(i, i % 2 == 0 ? 5.0 : 0.5, 0.0);
  comb.col(20) = R * Vector3d(19, 0, 0);
  comb.col(21) = R * Vector3d(0, 0, 0);
  comb.rowwise().reverseInPlace();
  // A washer: its hole is joined to its outline by a bridge, along which two corners lie in one place.
  constexpr int kSides = 16;
  Eigen::Matrix3Xd washer(3, 2 * kSides + 2);
  for (int i = 0; i <= kSides; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i % kSides) / kSides;
    const Vector3d d(std::cos(angle), std::sin(angle), 0.0);
    washer.col(i) = R * (3.0 * d);
    washer.col(2 * kSides + 1 - i) = R * d;
  }
  for (const Eigen::Matrix3Xd& polygon : {star, comb, washer}) {
    const auto triangles = cut_polygon(polygon);
    EXPECT_EQ(std::ssize(triangles), polygon.cols() - 2);
    Vector3d whole = Vector3d::Zero();
    for (Index i = 0; i < polygon.cols(); ++i) {
      whole += Vector3d(polygon.col(i)).cross(Vector3d(polygon.col((i + 1) % polygon.cols())));
    }
    double area = 0.0;
    for (const Vector3i& t : triangles) {
      const Vector3d a = polygon.col(t[0]), b = polygon.col(t[1]), c = polygon.col(t[2]);
      // Every part is wound like the whole, so that none overlaps another if the areas add up.
      EXPECT_GT((b - a).cross(c - a).dot(R.col(2)), 0.0);
      area += (b - a).cross(c - a).norm();
    }
    EXPECT_NEAR(area, std::abs(whole.dot(R.col(2))), 1e-12);
  }
}

/// What an outline across z sweeps along z, open at its ends; counter-clockwise.
TriangleMesh swept(const std::vector<Eigen::Vector2d>& outline, double length_m) {
  const auto count = static_cast<Index>(outline.size());
  TriangleMesh mesh{Eigen::Matrix3Xd(3, 2 * count), Eigen::Matrix3Xi(3, 2 * count)};
  for (Index i = 0; i < count; ++i) {
    mesh.vertices_m.col(i) << outline[i], 0.0;
    mesh.vertices_m.col(count + i) << outline[i], length_m;
    const int a = static_cast<int>(i), b = static_cast<int>((i + 1) % count), up = static_cast<int>(count);
    mesh.triangles.col(2 * i) << a, b, b + up;
    mesh.triangles.col(2 * i + 1) << a, b + up, a + up;
  }
  return mesh;
}

double degrees_between(const Vector3d& a, const Vector3d& b) {
  return std::acos(std::min(1.0, a.dot(b))) * 180.0 / std::numbers::pi;
}

// Triangles stand for what is round; but a flat face beside a fillet stays flat, and edges stay edges.
TEST(TriangleMesh, NormalsTurnWithWhatIsRound) {
  std::vector<Eigen::Vector2d> circle;
  for (int i = 0; i < 24; ++i) {
    const double angle = std::numbers::pi * i / 12.0;
    circle.emplace_back(10e-3 * std::cos(angle), 10e-3 * std::sin(angle));
  }
  const PointCloud rod = sample_mesh(swept(circle, 50e-3), 2000);
  for (Index i = 0; i < rod.points_m.cols(); ++i) {
    const Vector3d out(rod.points_m(0, i), rod.points_m(1, i), 0.0);
    ASSERT_LT(degrees_between(rod.normals.col(i), out.normalized()), 0.1) << "facets of 15 degrees";
  }

  // A plate of 60 x 20 mm whose corners are fillets of 4 mm, in facets of a right angle over 8.
  constexpr double kFillet_m = 4e-3;
  std::vector<Eigen::Vector2d> plate;
  for (int corner = 0; corner < 4; ++corner) {
    const Eigen::Vector2d middle((corner == 0 || corner == 3 ? 1.0 : -1.0) * (30e-3 - kFillet_m),
                                 (corner < 2 ? 1.0 : -1.0) * (10e-3 - kFillet_m));
    for (int i = 0; i <= 8; ++i) {
      const double angle = 0.5 * std::numbers::pi * (corner + i / 8.0);
      plate.push_back(middle + kFillet_m * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
  }
  const PointCloud filleted = sample_mesh(swept(plate, 50e-3), 4000);
  for (Index i = 0; i < filleted.points_m.cols(); ++i) {
    const Vector3d p = filleted.points_m.col(i), n = filleted.normals.col(i);
    if (std::abs(p.x()) < 30e-3 - kFillet_m) {
      ASSERT_LT(degrees_between(n, std::copysign(1.0, p.y()) * Vector3d::UnitY()), 0.5);
    } else if (std::abs(p.y()) > 10e-3 - kFillet_m) {
      const Vector3d off(p.x() - std::copysign(30e-3 - kFillet_m, p.x()),
                         p.y() - std::copysign(10e-3 - kFillet_m, p.y()), 0.0);
      ASSERT_LT(degrees_between(n, off.normalized()), 6.0);  // Half of a facet, where it meets the flat face.
    }
  }

  const PointCloud cube = sample_mesh(box({1e-2, 1e-2, 1e-2}), 600);
  for (Index i = 0; i < cube.points_m.cols(); ++i) {
    ASSERT_LT(1.0 - cube.normals.col(i).cwiseAbs().maxCoeff(), 1e-15);
  }
}

TEST(TriangleMesh, IsSampledByAreaWithItsNormals) {
  const Vector3d size_m(30e-3, 40e-3, 50e-3);
  const PointCloud cloud = sample_mesh(box(size_m), 3000);
  ASSERT_EQ(cloud.points_m.cols(), 3000);
  Eigen::Array3d samples = Eigen::Array3d::Zero();
  for (Index i = 0; i < 3000; ++i) {
    Index axis = 0;
    ASSERT_NEAR(cloud.normals.col(i).cwiseAbs().maxCoeff(&axis), 1.0, 1e-15);
    ASSERT_NEAR(cloud.points_m(axis, i), 0.5 * size_m[axis] * cloud.normals(axis, i), 1e-17);
    ++samples[axis];
  }
  const double area_m2 = 2.0 * (12e-4 + 20e-4 + 15e-4);
  const Eigen::Array3d expected = 3000.0 * 2.0 * Eigen::Array3d(20e-4, 15e-4, 12e-4) / area_m2;
  // Some tenths of the samples that line two faces, 2 x 100 to 130.
  EXPECT_LT((samples - expected).abs().maxCoeff(), 25.0);
  EXPECT_EQ(cloud.points_m, sample_mesh(box(size_m), 3000).points_m);
  EXPECT_THROW((void)sample_mesh(box(size_m), 0), std::invalid_argument);
  EXPECT_THROW((void)sample_mesh({Eigen::Matrix3Xd::Zero(3, 3), Vector3i(0, 1, 2)}, 10), std::invalid_argument);
}

}  // namespace
}  // namespace thenar::triangle_mesh_test
