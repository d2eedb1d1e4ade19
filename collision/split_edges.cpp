// SPDX-License-Identifier: Apache-2.0
#include "collision/split_edges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <unordered_map>
#include <utility>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::Vector3i;

// Open edges at a vertex that are compared, each with each: slits that end at one vertex are few.
constexpr std::size_t kMostSlits = 32;

/// The open edges of a mesh, while slits are closed.
class OpenEdges {
 public:
  OpenEdges(const TriangleMesh& mesh, const std::vector<EdgeSide>& sides) : vertices_m_(mesh.vertices_m) {
    triangles.reserve(mesh.triangles.cols());
    for (const auto triangle : mesh.triangles.colwise()) triangles.emplace_back(triangle);
    for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
      if (end - begin == 1) add(sides[begin].from, sides[begin].to, sides[begin].triangle);
    });
  }

  /// Splits the longer of two open edges that leave a vertex in one direction at the end of the shorter one, which is
  /// closed by that. Returns this end; -1: there are no two such edges.
  int split_at(int v, double apart_m) {
    const auto around = around_.find(v);
    if (around == around_.end() || around->second.size() > kMostSlits) return -1;
    for (const int a : around->second) {
      for (const int b : around->second) {
        if (a == b || !is_between(v, a, b, apart_m)) continue;
        if (split(v, a, b)) return a;
      }
    }
    return -1;
  }

  std::vector<Vector3i> triangles;

 private:
  static std::pair<int, int> key(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

  void add(int a, int b, Index triangle) {
    triangle_of_[key(a, b)] = triangle;
    around_[a].push_back(b);
    around_[b].push_back(a);
  }

  void remove(int a, int b) {
    triangle_of_.erase(key(a, b));
    std::erase(around_[a], b);
    std::erase(around_[b], a);
  }

  /// Tests whether vertex p lies on the line from a to b, and apart from its ends.
  [[nodiscard]] bool is_between(int a, int p, int b, double apart_m) const {
    const Vector3d line = vertices_m_.col(b) - vertices_m_.col(a), to = vertices_m_.col(p) - vertices_m_.col(a);
    const double length_m = line.norm(), along_m = line.dot(to) / length_m;
    const double end_m = 10.0 * apart_m;  // Nearer to an end the direction is not known.
    return along_m > end_m && along_m < length_m - end_m && line.cross(to).norm() <= apart_m * length_m;
  }

  /// Splits the open edge (v, b) at a, where the open edge (v, a) ends; false: they are of one triangle.
  bool split(int v, int a, int b) {
    const Index triangle = triangle_of_.at(key(v, b)), added = std::ssize(triangles);
    if (triangle_of_.at(key(v, a)) == triangle) return false;
    Vector3i& t = triangles[triangle];
    const int c = t.sum() - v - b;
    Vector3i other = t;
    std::ranges::replace(other, v, a);
    std::ranges::replace(t, b, a);
    triangles.push_back(other);
    if (const auto side = triangle_of_.find(key(b, c)); side != triangle_of_.end() && side->second == triangle) {
      side->second = added;
    }
    remove(v, a);
    remove(v, b);
    if (triangle_of_.contains(key(a, b))) {
      remove(a, b);
    } else {
      add(a, b, added);
    }
    return true;
  }

  const Eigen::Matrix3Xd& vertices_m_;
  std::map<std::pair<int, int>, Index> triangle_of_;
  std::unordered_map<int, std::vector<int>> around_;
};

}  // namespace

Index split_open_edges(TriangleMesh& mesh, std::vector<EdgeSide>& sides, double apart_m) {
  std::vector<int> begins;  // vertices at which slits may end
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (end - begin == 1) begins.insert(begins.end(), {sides[begin].from, sides[begin].to});
  });
  if (begins.empty()) return 0;
  OpenEdges open(mesh, sides);
  while (!begins.empty()) {
    const int at = begins.back();
    begins.pop_back();
    // The slit goes on from where it is closed to.
    const int next = open.split_at(at, apart_m);
    if (next >= 0) begins.insert(begins.end(), {at, next});
  }
  const Index splits = std::ssize(open.triangles) - mesh.triangles.cols();
  if (splits == 0) return 0;
  mesh.triangles.resize(3, std::ssize(open.triangles));
  for (Index i = 0; i < mesh.triangles.cols(); ++i) mesh.triangles.col(i) = open.triangles[i];
  sides = sorted_sides(mesh);
  return splits;
}

}  // namespace thenar
