// SPDX-License-Identifier: Apache-2.0
// What meshes of several solids, of doubled faces and with holes enclose, held against their formulas.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "collision/enclosed_solid.h"
#include "collision/joined_vertices.h"
#include "collision/triangle_mesh.h"
#include "collision/winding_number.h"

namespace thenar::mesh_solids_test {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::Vector3i;

TriangleMesh box(const Vector3d& low, const Vector3d& high) {
  TriangleMesh mesh{Matrix3Xd(3, 8), Eigen::Matrix3Xi(3, 12)};
  for (int i = 0; i < 8; ++i) {
    for (int k = 0; k < 3; ++k) mesh.vertices_m(k, i) = (i >> k & 1) != 0 ? high[k] : low[k];
  }
  mesh.triangles.transpose() << 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3,
      1, 4, 5, 7, 4, 7, 6;
  return mesh;
}

TriangleMesh inside_out(TriangleMesh mesh) {
  mesh.triangles.row(1).swap(mesh.triangles.row(2));
  return mesh;
}

TriangleMesh together(const std::vector<TriangleMesh>& parts) {
  TriangleMesh all{Matrix3Xd(3, 0), Eigen::Matrix3Xi(3, 0)};
  for (const TriangleMesh& part : parts) {
    const Index vertices = all.vertices_m.cols(), triangles = all.triangles.cols();
    all.vertices_m.conservativeResize(3, vertices + part.vertices_m.cols());
    all.vertices_m.rightCols(part.vertices_m.cols()) = part.vertices_m;
    all.triangles.conservativeResize(3, triangles + part.triangles.cols());
    all.triangles.rightCols(part.triangles.cols()) = part.triangles.array() + static_cast<int>(vertices);
  }
  return all;
}

/// The box with the other diagonal of each of its faces.
TriangleMesh other_diagonals(TriangleMesh mesh) {
  for (Index i = 0; i < 12; i += 2) {
    const Vector3i t = mesh.triangles.col(i);
    const int fourth = mesh.triangles(2, i + 1);
    mesh.triangles.col(i) = Vector3i(t[0], t[1], fourth);
    mesh.triangles.col(i + 1) = Vector3i(t[1], t[2], fourth);
  }
  return mesh;
}

double volume_m3(const TriangleMesh& mesh) {
  double volume = 0.0;
  for (const auto t : mesh.triangles.colwise()) {
    const Vector3d a = mesh.vertices_m.col(t[0]), b = mesh.vertices_m.col(t[1]), c = mesh.vertices_m.col(t[2]);
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

TEST(MeshSolids, JoinsWhatIsNearAndNothingElse) {
  std::mt19937_64 random(1);
  const auto uniform = [&] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
  Matrix3Xd vertices(3, 400);
  std::vector<int> expected(400);
  for (int i = 0; i < 100; ++i) {
    for (int copy = 0; copy < 4; ++copy) {
      // Around places on the borders of cells, too.
      const Vector3d place(i % 5, i / 5 % 5, std::floor(i / 25.0));
      vertices.col(100 * copy + i) = place + 4e-10 * Vector3d(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5);
      expected[100 * copy + i] = i;
    }
  }
  EXPECT_EQ(join_vertices(vertices, 1e-9), expected);
  // A chain is joined as a whole; what is a thousandth of the way apart is not.
  Matrix3Xd chain = Matrix3Xd::Zero(3, 50);
  for (int i = 0; i < 50; ++i) chain(i % 2, i) = 0.0;
  for (int i = 0; i < 49; ++i) chain.col(i) = Vector3d(0.9e-9 * i, -0.3e-9 * i, 0.1e-9 * i);
  chain.col(49) = Vector3d(1e-6, 0, 0);
  const std::vector<int> joined = join_vertices(chain, 1e-9);
  for (int i = 0; i < 49; ++i) EXPECT_EQ(joined[i], 0);
  EXPECT_EQ(joined[49], 49);
  EXPECT_EQ(join_vertices(chain, 0.0)[48], 48);
  EXPECT_EQ(join_vertices(1e300 * chain, 1e-9)[48], 48);
}

TEST(MeshSolids, WindingNumbersCountSolids) {
  const TriangleMesh mesh = together({box({0, 0, 0}, {4, 4, 4}), box({1, 1, 1}, {3, 3, 3}),
                                      inside_out(box({5, 0, 0}, {7, 2, 2})), box({20, 0, 0}, {21, 1, 1})});
  const WindingNumber winding(mesh);
  EXPECT_NEAR(winding({2, 2, 2}), 2.0, 0.02);
  EXPECT_NEAR(winding({0.5, 0.5, 0.5}), 1.0, 0.02);
  EXPECT_NEAR(winding({6, 1, 1}), -1.0, 0.02);
  EXPECT_NEAR(winding({20.5, 0.5, 0.5}), 1.0, 0.02);
  EXPECT_NEAR(winding({10, 9, 9}), 0.0, 0.02);
  EXPECT_NEAR(winding({4.0001, 2, 2}), 0.0, 0.02);
  // In the middle of an open face.
  TriangleMesh open = box({0, 0, 0}, {1, 1, 1});
  open.triangles.conservativeResize(3, 10);
  EXPECT_NEAR(WindingNumber(open)({0.5, 0.5, 1.0}), 0.5, 1e-12);
  EXPECT_EQ(WindingNumber(TriangleMesh{Matrix3Xd(3, 0), Eigen::Matrix3Xi(3, 0)})({0, 0, 0}), 0.0);
}

/// What a mesh is after mend(), against the box from 0 to (3, 4, 6).
void expect_box(TriangleMesh mesh, Index doubled) {
  const MeshMending mending = mend(mesh);
  EXPECT_EQ(mending.doubled, doubled);
  EXPECT_EQ(mending.open_edges, 0);
  EXPECT_EQ(mending.at_odds, 0);
  EXPECT_NEAR(volume_m3(mesh), 72.0, 1e-12);
  const EnclosedSolid solid = enclosed_solid(mesh);
  EXPECT_NEAR(solid.volume_m3, 72.0, 1e-12);
  EXPECT_LT((solid.centroid_m - Vector3d(1.5, 2, 3)).norm(), 1e-13);
  EXPECT_EQ(solid.error_m, 0.0);
  double covered = 1.0;
  const PointCloud cloud = sample_mesh(mesh, 500, 1, &covered);
  EXPECT_EQ(covered, 0.0);
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    const Vector3d p = cloud.points_m.col(i), n = cloud.normals.col(i);
    Index axis = 0;
    ASSERT_NEAR(n.cwiseAbs().maxCoeff(&axis), 1.0, 1e-12);
    ASSERT_NEAR(p[axis], n[axis] > 0.0 ? Vector3d(3, 4, 6)[axis] : 0.0, 1e-12);
  }
}

TEST(MeshSolids, DoubledFacesAreOneSurface) {
  const TriangleMesh plain = box({0, 0, 0}, {3, 4, 6});
  expect_box(plain, 0);
  expect_box(together({plain, plain}), 12);
  expect_box(together({plain, inside_out(plain)}), 12);
  expect_box(together({inside_out(plain), plain}), 12);
  expect_box(together({plain, inside_out(other_diagonals(plain))}), 12);
  expect_box(together({plain, plain, inside_out(plain)}), 24);
  // A single face twice.
  TriangleMesh face = plain;
  face.triangles = plain.triangles.leftCols(2).eval();
  expect_box(together({plain, face}), 2);
  expect_box(together({plain, inside_out(face)}), 2);
}

TEST(MeshSolids, SolidsThatTouchAreOne) {
  for (const bool reversed : {false, true}) {
    for (const bool crossed : {false, true}) {
      std::vector<TriangleMesh> slabs;
      for (int k = 0; k < 6; ++k) {
        TriangleMesh slab = box(Vector3d(0, 0, k), Vector3d(3, 4, k + 1.0));
        if (crossed && k % 2 == 0) slab = other_diagonals(slab);
        slabs.push_back(reversed ? inside_out(slab) : slab);
      }
      expect_box(together(slabs), 20);
    }
  }
}

TEST(MeshSolids, OverlappingSolidsCountOnce) {
  struct Case {
    TriangleMesh mesh;
    double volume_m3;
    Vector3d centroid_m;
  };
  const TriangleMesh big = box({0, 0, 0}, {3, 4, 6});
  const std::vector<Case> cases = {
      // One within the other; over each other; touching on a part of a face; within a cavity; far apart.
      {together({big, box({1, 1, 1}, {2, 2, 2})}), 72.0, {1.5, 2, 3}},
      {together({big, box({1, 0, 0}, {5, 4, 6})}), 120.0, {2.5, 2, 3}},
      {together({big, box({3, 1, 1}, {4, 2, 2})}), 73.0, Vector3d(72 * 1.5 + 3.5, 72 * 2 + 1.5, 72 * 3 + 1.5) / 73.0},
      {together({big, inside_out(box({1, 1, 1}, {2, 2, 3}))}), 70.0,
       Vector3d(72 * 1.5 - 2 * 1.5, 72 * 2 - 2 * 1.5, 72 * 3 - 2 * 2) / 70.0},
      {together({big, box({10, 0, 0}, {13, 4, 6})}), 144.0, {6.5, 2, 3}},
  };
  for (const Case& test : cases) {
    TriangleMesh mesh = test.mesh;
    mend(mesh);
    const EnclosedSolid solid = enclosed_solid(mesh);
    EXPECT_NEAR(solid.volume_m3, test.volume_m3, 2e-3 * test.volume_m3);
    EXPECT_LT((solid.centroid_m - test.centroid_m).norm(), 5e-3);
  }
  // No sample of the union lies inside of it.
  TriangleMesh cross = cases[1].mesh;
  mend(cross);
  double covered = 0.0;
  const PointCloud cloud = sample_mesh(cross, 800, 1, &covered);
  EXPECT_NEAR(covered, (24.0 + 24.0) / (108.0 + 128.0), 0.01);
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    const Vector3d p = cloud.points_m.col(i);
    ASSERT_FALSE(p.x() > 1e-2 && p.x() < 5 - 1e-2 && p.y() > 1e-2 && p.y() < 4 - 1e-2 && p.z() > 1e-2 &&
                 p.z() < 6 - 1e-2);
  }
}

TEST(MeshSolids, HolesSayHowMuchTheyMatter) {
  TriangleMesh open = box({0, 0, 0}, {3, 4, 6});
  open.triangles.conservativeResize(3, 10);  // without its top
  const EnclosedSolid solid = enclosed_solid(open);
  EXPECT_NEAR(solid.volume_m3, 72.0, 1e-12);
  EXPECT_LT((solid.centroid_m - Vector3d(1.5, 2, 3)).norm(), 1e-13);
  EXPECT_NEAR(solid.error_m, 2.0 / 3.0 * 12.0 * std::sqrt(12.0 / std::numbers::pi) * 3.0 / 72.0, 1e-12);
  EXPECT_FALSE(enclosed_solid(inside_out(open)).volume_m3 > 0.0);
}

TEST(MeshSolids, CornersThatDifferByRoundingAreOne) {
  for (const double noise : {1e-18, 1e-11, 2e-7}) {
    std::mt19937_64 random(2);
    const TriangleMesh sound = box({0, 0, 0}, {3, 4, 6});
    TriangleMesh loose{Matrix3Xd(3, 36), Eigen::Matrix3Xi(3, 12)};
    for (int i = 0; i < 36; ++i) {
      const auto off = [&] { return 6.0 * noise * (static_cast<double>(random() % 1000) / 500.0 - 1.0); };
      loose.vertices_m.col(i) = sound.vertices_m.col(sound.triangles(i % 3, i / 3)) + Vector3d(off(), off(), off());
      loose.triangles(i % 3, i / 3) = i;
    }
    // A vertex that no triangle has says nothing of the size.
    loose.vertices_m.conservativeResize(3, 37);
    loose.vertices_m.col(36).setConstant(std::numeric_limits<double>::quiet_NaN());
    const MeshMending mending = mend(loose);
    EXPECT_EQ(mending.open_edges, 0) << noise;
    EXPECT_EQ(mending.joined_m > 0.0, noise > 1e-8);
    EXPECT_NEAR(enclosed_solid(loose).volume_m3, 72.0, 1e-4);
  }
}

// A vertex on the side of a neighbour, with a triangle without area between, closes the surface.
TEST(MeshSolids, TrianglesWithoutAreaCloseGaps) {
  TriangleMesh mesh = box({0, 0, 0}, {3, 4, 6});
  mesh.vertices_m.conservativeResize(3, 9);
  const Vector3i first = mesh.triangles.col(0);
  mesh.vertices_m.col(8) = 0.5 * (mesh.vertices_m.col(first[0]) + mesh.vertices_m.col(first[1]));
  mesh.triangles.conservativeResize(3, 14);
  mesh.triangles.col(0) = Vector3i(first[0], 8, first[2]);
  mesh.triangles.col(12) = Vector3i(8, first[1], first[2]);
  mesh.triangles.col(13) = Vector3i(first[0], first[1], 8);
  const MeshMending mending = mend(mesh);
  EXPECT_EQ(mending.open_edges, 0);
  EXPECT_EQ(mending.dropped, 1);
  EXPECT_TRUE(sample_mesh(mesh, 200).normals.allFinite());
}

/// A box whose side at x = k is cut into `cuts[k]` rectangles of the same width along y, the others not at all.
TriangleMesh box_of_bricks(const Vector3d& size, const std::vector<int>& cuts) {
  std::vector<TriangleMesh> faces;
  const auto add = [&](const Vector3d& at, const Vector3d& a, const Vector3d& b) {
    TriangleMesh face{Matrix3Xd(3, 4), Eigen::Matrix3Xi(3, 2)};
    face.vertices_m << at, at + a, at + a + b, at + b;
    face.triangles.transpose() << 0, 1, 2, 0, 2, 3;
    faces.push_back(face);
  };
  const Vector3d x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z()), none = Vector3d::Zero();
  add(none, y, x);
  add(z, x, y);
  add(none, x, z);
  add(y, z, x);
  add(none, z, y);
  // Rows of bricks along y, each row cut in another way.
  const double rows = static_cast<double>(cuts.size());
  for (std::size_t row = 0; row < cuts.size(); ++row) {
    const Vector3d at = x + z * static_cast<double>(row) / rows;
    for (int k = 0; k < cuts[row]; ++k) add(at + y * k / cuts[row], y / cuts[row], z / rows);
  }
  return together(faces);
}

// One large face along several small ones, as programs leave them that merge voxels, or that cut plane faces at will.
TEST(MeshSolids, EdgesAreSplitAtCornersOnThem) {
  for (const std::vector<int>& cuts : {std::vector<int>{2}, {7}, {3, 2}, {1, 3, 4, 5, 1, 7}, {11, 13, 17, 1, 19}}) {
    for (const double turn : {0.0, 0.3}) {
      TriangleMesh mesh = box_of_bricks({3, 4, 6}, cuts);
      const Eigen::Matrix3d R = Eigen::AngleAxisd(turn, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
      mesh.vertices_m = (R * mesh.vertices_m).eval();
      const MeshMending mending = mend(mesh);
      EXPECT_GT(mending.split, 0);
      EXPECT_EQ(mending.open_edges, 0);
      EXPECT_EQ(mending.at_odds, 0);
      const EnclosedSolid solid = enclosed_solid(mesh);
      EXPECT_NEAR(solid.volume_m3, 72.0, 1e-9);
      EXPECT_LT((solid.centroid_m - R * Vector3d(1.5, 2, 3)).norm(), 1e-9);
    }
  }
  // A hole stays one.
  TriangleMesh open = box_of_bricks({3, 4, 6}, {3, 2});
  open.triangles.conservativeResize(3, open.triangles.cols() - 2);
  EXPECT_EQ(mend(open).open_edges, 5);
  TriangleMesh whole = box({0, 0, 0}, {3, 4, 6});
  EXPECT_EQ(mend(whole).split, 0);
}

/// How long it takes to mend, measure and sample a mesh [s].
double seconds_for(TriangleMesh mesh) {
  const auto begin = std::chrono::steady_clock::now();
  mend(mesh);
  (void)enclosed_solid(mesh);
  double covered = 0.0;
  (void)sample_mesh(mesh, 20, 1, &covered);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Meshes at which one loop within another would take minutes.
TEST(MeshSolids, TakesTimeInProportion) {
  constexpr int kMany = 20000;
  TriangleMesh fan{Matrix3Xd(3, kMany + 2), Eigen::Matrix3Xi(3, 2 * kMany)};
  fan.vertices_m.col(kMany) = Vector3d(0, 0, 1);
  fan.vertices_m.col(kMany + 1) = Vector3d(0, 0, -1);
  for (int i = 0; i < kMany; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / kMany;
    fan.vertices_m.col(i) = Vector3d(std::cos(turn), std::sin(turn), 0);
    fan.triangles.col(2 * i) = Vector3i(i, (i + 1) % kMany, kMany);
    fan.triangles.col(2 * i + 1) = Vector3i((i + 1) % kMany, i, kMany + 1);
  }
  EXPECT_LT(seconds_for(fan), 2.0);
  std::vector<TriangleMesh> dust;
  dust.push_back(box({0, 0, 0}, {60, 60, 60}));
  TriangleMesh all{Matrix3Xd(3, 4 * kMany), Eigen::Matrix3Xi(3, 4 * kMany)};
  for (int i = 0; i < kMany; ++i) {
    const Vector3d at(i % 20, i / 20 % 20, std::floor(i / 400.0));
    all.vertices_m.middleCols<4>(4 * i) << at, at + 0.5 * Vector3d::UnitX(), at + 0.5 * Vector3d::UnitY(),
        at + 0.5 * Vector3d::UnitZ();
    for (int k = 0; k < 4; ++k) {
      all.triangles.col(4 * i + k) = Vector3i(4 * i + (k + 1) % 4, 4 * i + (k + 2) % 4, 4 * i + (k + 3) % 4);
    }
  }
  EXPECT_LT(seconds_for(all), 2.0);
  EXPECT_LT(seconds_for(box_of_bricks({3, 4, 6}, std::vector<int>(100, 400))), 2.0);
  EXPECT_LT(seconds_for(box_of_bricks({3, 4, 6}, {kMany})), 2.0);
  // A spiral, of which each cut leaves the next one far away.
  Matrix3Xd spiral(3, 1000);
  for (int i = 0; i < 500; ++i) {
    const double turn = 0.15 * i;
    const Vector3d d(std::cos(turn), std::sin(turn), 0);
    spiral.col(i) = (1.0 + 0.1 * turn) * d;
    spiral.col(999 - i) = (1.05 + 0.1 * turn) * d;
  }
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(cut_polygon(spiral).size(), 998U);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 0.2);
}

}  // namespace
}  // namespace thenar::mesh_solids_test
