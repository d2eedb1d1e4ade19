#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

/// A solid's surface as triangles, counter-clockwise as seen from outside.
struct TriangleMesh {
  Eigen::Matrix3Xd vertices_m;
  Eigen::Matrix3Xi triangles;  ///< Numbers of vertices.
};

/// A polygon, nearly plane, as triangles that are wound like it; numbers of its corners. A polygon of n corners has n -
/// 2, fewer if it crosses itself. Cost O(n^2), at worst O(n^3).
[[nodiscard]] std::vector<Eigen::Vector3i> cut_polygon(const Eigen::Matrix3Xd& corners);

/// What mend() found in a mesh.
struct MeshMending {
  Eigen::Index dropped = 0;     ///< Triangles without area.
  Eigen::Index turned = 0;      ///< Triangles that were wound the other way than their neighbours, or inside out.
  Eigen::Index edges = 0;       ///< Of the mended mesh.
  Eigen::Index open_edges = 0;  ///< Edges of a single triangle: the rims of holes.
  Eigen::Index at_odds = 0;     ///< Edges whose two triangles cannot agree, as on a Moebius strip.
};

/// Makes a mesh whose vertices are joined where they coincide, whose triangles have area, and are wound like their
/// neighbours: in each connected part like the majority. A part that then is inside out is turned, unless it lies
/// within another one, and so may be its cavity.
/// Requires  Finite vertices, numbers of vertices within range.
MeshMending mend(TriangleMesh& mesh);

/// Exactly `count` blue-noise samples of the triangles. Their normals turn from triangle to triangle as those of the
/// smooth surface that the mesh stands for, but not over edges of more than 20 degrees. Same seed, same cloud.
/// Throws std::invalid_argument if count < 1 or if no triangle has area.
[[nodiscard]] PointCloud sample_mesh(const TriangleMesh& mesh, Eigen::Index count, std::uint32_t seed = 1);

}  // namespace thenar
