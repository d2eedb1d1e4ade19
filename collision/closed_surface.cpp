// SPDX-License-Identifier: Apache-2.0
#include "collision/closed_surface.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kMostSquares = 12'000.0;  // Approximate number of cell sides in the surface, at first.
constexpr int kGrids = 3;                  // Each is twice as fine as the one before it.
constexpr Index kMostPoints = 20'000'000;  // Largest number of points of a grid, most of which are empty.
constexpr Index kMostDistances = 500'000;
constexpr double kBare = 0.005;  // A larger share of samples without triangles is a part that is missing.
constexpr double kSharp = 0.1;   // Relative to the largest eigenvalue: less is no edge, but a curve, or noise.

/// A plane of the surface, where it crosses an edge of the grid.
struct Crossing {
  Vector3d point_m, normal;
};

/// The vertex of a cell: where the planes of its crossings meet.
struct CellVertex {
  std::vector<Crossing> planes;
  int number = -1;
};

class Grid {
 public:
  Grid(const ImplicitSurface& surface, double cell_m)
      : surface_(surface), cell_m_(cell_m), reach_m_(8.0 * cell_m + surface.support_m()) {
    origin_m_ = surface.bounds().min() - Vector3d::Constant(3.37 * cell_m);  // A face between the points of the grid.
    size_ = ((surface.bounds().sizes() / cell_m).array().ceil().cast<int>() + 8).matrix();
  }

  [[nodiscard]] std::optional<TriangleMesh> contour() {
    if (static_cast<double>(size_[0]) * size_[1] * size_[2] > static_cast<double>(kMostPoints)) return std::nullopt;
    if (!measure() || !follow() || !cross() || !covers()) return std::nullopt;
    return mesh();
  }

 private:
  [[nodiscard]] Index index(const Vector3i& at) const {
    return (static_cast<Index>(at[2]) * size_[1] + at[1]) * size_[0] + at[0];
  }
  [[nodiscard]] Vector3d place_m(const Vector3i& at) const { return origin_m_ + cell_m_ * at.cast<double>(); }
  [[nodiscard]] Vector3i cell_of(const Vector3d& x_m) const {
    return ((x_m - origin_m_) / cell_m_).array().floor().cast<int>().matrix();
  }
  [[nodiscard]] bool has(const Vector3i& at) const {
    return (at.array() >= 1).all() && (at.array() < size_.array() - 2).all();
  }
  [[nodiscard]] float& f_m(const Vector3i& at) { return f_m_[static_cast<std::size_t>(index(at))]; }
  void measure_at(const Vector3i& at);
  bool measure();
  bool follow();
  bool cross();
  [[nodiscard]] Crossing crossing(Vector3d in_m, Vector3d out_m, double f_in, double f_out) const;
  [[nodiscard]] bool covers() const;
  [[nodiscard]] Vector3d vertex_m(const Vector3i& cell, const std::vector<Crossing>& planes) const;
  [[nodiscard]] TriangleMesh mesh();

  const ImplicitSurface& surface_;
  double cell_m_, reach_m_;
  Vector3d origin_m_;
  Vector3i size_;
  std::vector<float> f_m_;  ///< At each point; NaN: far from the surface.
  std::vector<Vector3i> known_;
  std::unordered_map<Index, CellVertex> cells_;
  std::vector<std::array<Vector3i, 4>> quads_;  ///< Cells around a crossed edge, counter-clockwise from outside.
};

void Grid::measure_at(const Vector3i& at) {
  if (!has(at) || !std::isnan(f_m(at))) return;
  const std::optional<SurfaceDistance> found = surface_.distance(place_m(at), reach_m_);
  if (!found) return;
  f_m(at) = static_cast<float>(found->distance_m);
  known_.push_back(at);
}

/// Computes the distances of all points of cells with samples, and of the cells around these. False if too many.
bool Grid::measure() {
  f_m_.assign(static_cast<std::size_t>(index(size_)), std::numeric_limits<float>::quiet_NaN());
  std::vector<bool> seen(f_m_.size(), false);
  for (Index i = 0; i < surface_.cloud().points_m.cols(); ++i) {
    const Vector3i cell = cell_of(surface_.cloud().points_m.col(i));
    const Index first = index(cell);
    if (seen[static_cast<std::size_t>(first)]) continue;
    seen[static_cast<std::size_t>(first)] = true;
    for (int k = 0; k < 64; ++k) measure_at(cell + Vector3i(k % 4 - 1, k / 4 % 4 - 1, k / 16 - 1));
    if (static_cast<Index>(known_.size()) > kMostDistances) return false;
  }
  return true;
}

/// Computes the distances where the surface continues without samples, as over a hole. False if too many.
bool Grid::follow() {
  for (std::size_t i = 0; i < known_.size(); ++i) {
    const Vector3i at = known_[i];
    for (int k = 0; k < 6; ++k) {
      const int axis = k / 2;
      const Vector3i way = Vector3i::Unit(axis), next = k % 2 == 0 ? Vector3i(at + way) : Vector3i(at - way);
      if (!has(next) || std::isnan(f_m(next)) || (f_m(at) < 0.0F) == (f_m(next) < 0.0F)) continue;
      const Vector3i u = Vector3i::Unit((axis + 1) % 3), v = Vector3i::Unit((axis + 2) % 3);
      for (int j = 0; j < 18; ++j) {
        measure_at(at.cwiseMin(next) + (j % 3 - 1) * u + (j / 3 % 3 - 1) * v + j / 9 * way);
      }
    }
    if (static_cast<Index>(known_.size()) > kMostDistances) return false;
  }
  return true;
}

/// Finds the surface on an edge of the grid, between a point inside and one outside: regula falsi, Illinois variant.
Crossing Grid::crossing(Vector3d in_m, Vector3d out_m, double f_in, double f_out) const {
  Crossing found{in_m, Vector3d::Zero()};
  for (int i = 0; i < 4; ++i) {
    found.point_m = in_m + (out_m - in_m) * (f_in / (f_in - f_out));
    const std::optional<SurfaceDistance> at = surface_.distance(found.point_m, reach_m_);
    if (!at) break;
    found.normal = at->normal;
    if (std::abs(at->distance_m) < 1e-3 * cell_m_) break;
    if (at->distance_m < 0.0) {
      in_m = found.point_m;
      f_in = at->distance_m;
      f_out *= 0.5;
    } else {
      out_m = found.point_m;
      f_out = at->distance_m;
      f_in *= 0.5;
    }
  }
  return found;
}

/// Finds all edges that the surface crosses. False if the surface continues where no distance is known.
bool Grid::cross() {
  for (const Vector3i& at : known_) {
    const double f = f_m(at);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3i next = at + Vector3i::Unit(axis);
      const double g = has(next) ? f_m(next) : f;
      if (std::isnan(g) || (f < 0.0) == (g < 0.0)) continue;
      const Crossing plane =
          f < 0.0 ? crossing(place_m(at), place_m(next), f, g) : crossing(place_m(next), place_m(at), g, f);
      if (plane.normal.isZero(0.0)) return false;
      const Vector3i u = Vector3i::Unit((axis + 1) % 3), v = Vector3i::Unit((axis + 2) % 3);
      std::array<Vector3i, 4> around = {at, at - u, at - u - v, at - v};
      if (g < 0.0) std::swap(around[1], around[3]);
      for (const Vector3i& cell : around) {
        for (int k = 0; k < 8; ++k) {
          const Vector3i corner = cell + Vector3i(k & 1, k >> 1 & 1, k >> 2 & 1);
          if (!has(corner) || std::isnan(f_m(corner))) return false;
        }
        cells_[index(cell)].planes.push_back(plane);
      }
      quads_.push_back(around);
    }
  }
  return !quads_.empty();
}

/// Tests whether nearly every sample has a crossing of its own side of the solid within two cells: a wall without grid
/// points has none.
bool Grid::covers() const {
  Index bare = 0;
  const PointCloud& cloud = surface_.cloud();
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    const Vector3d x_m = cloud.points_m.col(i), n = cloud.normals.col(i);
    const Vector3i cell = cell_of(x_m);
    bool found = false;
    for (int k = 0; k < 27 && !found; ++k) {
      const auto near = cells_.find(index(cell + Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
      if (near == cells_.end()) continue;
      found = std::ranges::any_of(near->second.planes, [&](const Crossing& plane) {
        return plane.normal.dot(n) > 0.5 && std::abs(plane.normal.dot(x_m - plane.point_m)) < 0.5 * cell_m_;
      });
    }
    bare += found ? 0 : 1;
  }
  return static_cast<double>(bare) <= kBare * static_cast<double>(cloud.points_m.cols());
}

/// Finds the best intersection of a cell's planes, least squares about the mean of their points: in the cell, so that
/// triangles do not turn over.
Vector3d Grid::vertex_m(const Vector3i& cell, const std::vector<Crossing>& planes) const {
  Vector3d middle_m = Vector3d::Zero(), b = Vector3d::Zero();
  for (const Crossing& plane : planes) middle_m += plane.point_m / static_cast<double>(planes.size());
  Matrix3d A = Matrix3d::Zero();
  for (const Crossing& plane : planes) {
    A += plane.normal * plane.normal.transpose();
    b += plane.normal * plane.normal.dot(plane.point_m - middle_m);
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> spread(A);
  Vector3d step_m = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vector3d way = spread.eigenvectors().col(i);
    const double stiff = spread.eigenvalues()[i];
    if (stiff > kSharp * spread.eigenvalues()[2]) step_m += way * (way.dot(b) / stiff);
  }
  const Vector3d low_m = place_m(cell);
  return (middle_m + step_m).cwiseMax(low_m).cwiseMin(low_m + Vector3d::Constant(cell_m_));
}

TriangleMesh Grid::mesh() {
  TriangleMesh mesh{Eigen::Matrix3Xd(3, static_cast<Index>(cells_.size())),
                    Eigen::Matrix3Xi(3, 2 * static_cast<Index>(quads_.size()))};
  int vertices = 0;
  Index triangles = 0;
  const auto number = [&](const Vector3i& cell) {
    CellVertex& vertex = cells_.at(index(cell));
    if (vertex.number < 0) {
      vertex.number = vertices++;
      mesh.vertices_m.col(vertex.number) = vertex_m(cell, vertex.planes);
    }
    return vertex.number;
  };
  for (const std::array<Vector3i, 4>& quad : quads_) {
    const std::array<int, 4> q = {number(quad[0]), number(quad[1]), number(quad[2]), number(quad[3])};
    const auto normal = [&](int a, int b, int c) -> Vector3d {
      const Vector3d p_m = mesh.vertices_m.col(a);
      return (mesh.vertices_m.col(b) - p_m).cross(mesh.vertices_m.col(c) - p_m).normalized();
    };
    // Cut so that the two halves bend the less.
    const bool other =
        normal(q[0], q[1], q[2]).dot(normal(q[0], q[2], q[3])) < normal(q[1], q[2], q[3]).dot(normal(q[1], q[3], q[0]));
    const int s = other ? 1 : 0;
    mesh.triangles.col(triangles++) << q[s], q[s + 1], q[s + 2];
    mesh.triangles.col(triangles++) << q[s], q[s + 2], q[(s + 3) % 4];
  }
  return mesh;
}

}  // namespace

std::optional<TriangleMesh> closed_surface(const ImplicitSurface& surface) {
  const double spacing_m = surface.support_m() / 2.2;
  const double area_m2 = static_cast<double>(surface.cloud().points_m.cols()) * spacing_m * spacing_m;
  double cell_m = std::max(1.5 * spacing_m, std::sqrt(area_m2 / kMostSquares));
  for (int i = 0; i < kGrids; ++i, cell_m *= 0.5) {
    std::optional<TriangleMesh> mesh = Grid(surface, cell_m).contour();
    if (mesh) return mesh;
  }
  return std::nullopt;
}

}  // namespace thenar
