// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "collision/triangle_mesh.h"

namespace thenar {

/// A builder of vertices and triangles in the order of reading. Polygons are triangulated by ear clipping.
class MeshBuilder {
 public:
  [[nodiscard]] std::size_t vertices() const { return vertices_.size() / 3; }
  [[nodiscard]] bool has_faces() const { return !triangles_.empty(); }

  /// Adds a vertex, and a face by the numbers of its vertices, from 0. They return what is wrong, and add nothing then;
  /// empty: nothing is.
  [[nodiscard]] std::string add_vertex(const Eigen::Vector3d& vertex);
  [[nodiscard]] std::string add_face(std::vector<int> corners);
  /// Adds a triangle of the last three vertices.
  void add_triangle();

  [[nodiscard]] TriangleMesh mesh() const;

 private:
  /// Cuts a polygon up; one with the same corners as an earlier one, either way round, as that: they are the two sides
  /// of a surface.
  void add_polygon(const std::vector<int>& corners);

  std::vector<double> vertices_;
  std::vector<int> triangles_;
  /// Of faces with more than four corners, from the least one on in the direction of the lesser neighbour: their
  /// triangles' first place and end, and whether that is their own direction.
  struct Cut {
    std::size_t begin, end;
    bool is_own;
  };
  std::map<std::vector<int>, Cut> cuts_;
};

}  // namespace thenar
