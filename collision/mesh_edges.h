// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "collision/triangles.h"

namespace thenar {

/// A side of a triangle along an edge, which runs from the lesser vertex to the greater.
struct EdgeSide {
  int from, to;
  int along;  ///< 1: the triangle has the edge in this direction; -1: in the other.
  Eigen::Index triangle;
};

/// Returns the sides of all triangles, in the order of edges, of an edge in that of triangles. Cost O(n log n).
[[nodiscard]] std::vector<EdgeSide> sorted_sides(const TriangleMesh& mesh);

/// Calls `f(begin, end)` for the sides of each edge.
template <typename F>
void for_each_edge(const std::vector<EdgeSide>& sides, const F& f) {
  for (std::size_t begin = 0; begin < sides.size();) {
    std::size_t end = begin + 1;
    while (end < sides.size() && sides[end].from == sides[begin].from && sides[end].to == sides[begin].to) ++end;
    f(begin, end);
    begin = end;
  }
}

/// Sets of numbers from 0 on, each named by its least one [union-find: Galler, Fischer 1964].
class NumberSets {
 public:
  explicit NumberSets(Eigen::Index count);
  [[nodiscard]] int of(Eigen::Index i);
  /// Returns false if they are one set already.
  bool join(Eigen::Index a, Eigen::Index b);

 private:
  std::vector<int> above_;
};

/// Leaves out faces that lie on others of the same three vertices, and returns their number. Two that face each other
/// are a wall between two solids that touch, and both are left out; or the two sides of one surface, which one of them
/// stands for: whichever leaves fewer edges open. `sides` are the mesh's, before and after. Cost O(n log n).
Eigen::Index remove_doubled_faces(TriangleMesh& mesh, std::vector<EdgeSide>& sides);

/// A hole's rim.
struct MeshRim {
  Eigen::Vector3d middle_m;  ///< The mean of its vertices.
  double area_m2;            ///< Of its flat part.
};

/// Closes a mesh: each connected rim of edges, along which triangles do not run equally often both ways, gets triangles
/// to its middle. Cost O(n log n).
std::vector<MeshRim> close_rims(TriangleMesh& mesh);

/// Tests for a mesh of several parts, between which no edge has just two triangles; or with more of them at an edge.
/// Then its solids may overlap. Cost O(n log n).
[[nodiscard]] bool has_several_parts(const TriangleMesh& mesh);

}  // namespace thenar
