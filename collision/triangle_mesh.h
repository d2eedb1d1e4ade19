// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "collision/point_cloud.h"
#include "collision/triangles.h"

namespace thenar {

/// Triangulates a nearly plane polygon; returns indices of its corners, in its orientation. A polygon of n corners has
/// n - 2 triangles, fewer if it crosses itself. Cost O(n^2).
[[nodiscard]] std::vector<Eigen::Vector3i> cut_polygon(const Eigen::Matrix3Xd& corners);

/// Faults that mend() found in a mesh.
struct MeshMending {
  Eigen::Index dropped = 0;     ///< Triangles without area.
  Eigen::Index doubled = 0;     ///< Triangles that lay on others of the same vertices.
  Eigen::Index split = 0;       ///< Splits of open edges where ends of others lay on them.
  double joined_m = 0.0;        ///< Vertices up to this far apart were joined; 0: none but by rounding.
  Eigen::Index turned = 0;      ///< Triangles that were oriented opposite to their neighbours, or inside out.
  Eigen::Index edges = 0;       ///< Edges of the mended mesh.
  Eigen::Index open_edges = 0;  ///< Edges of a single triangle: the rims of holes.
  Eigen::Index at_odds = 0;     ///< Edges whose two triangles cannot agree, as on a Moebius strip.
};

/// Joins vertices that coincide, to 1e-9 of the mesh's size, or where that leaves it open to 1e-6; drops triangles
/// without area, and those that lie on others: the second sides of a surface, and walls between solids that touch.
/// Open edges are split where the ends of others lie on them, to 1e-6 of the size.
/// Orients triangles like their neighbours: in each connected part like the majority. A part that is then inside out is
/// reversed, unless it lies within another one, and so may be its cavity.
/// Requires  Finite vertices, as far as triangles have them; numbers of vertices within range.
/// Cost O(n log n).
MeshMending mend(TriangleMesh& mesh);

/// Draws exactly `count` blue-noise samples of the triangles. Normals vary between triangles as on the smooth surface
/// that the mesh approximates, but not over edges of more than 20 degrees. Same seed, same cloud.
/// With `covered`, a mesh of several parts is the union of their solids, by the winding number: triangles have no
/// samples where their outside is inside of it, and `covered` becomes that share of them.
/// Throws std::invalid_argument if count < 1 or if no triangle has area, or too little of them is not covered.
[[nodiscard]] PointCloud sample_mesh(const TriangleMesh& mesh, Eigen::Index count, std::uint32_t seed = 1,
                                     double* covered = nullptr);

}  // namespace thenar
