// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "collision/polygon.h"

namespace thenar {

/// A plane of a locally convex solid, near a point x of another surface with the outward unit normal N.
struct CellFace {
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< Component of the plane's outward normal across N.
  double facing = 0.0;                              ///< Its component along -N; > 0 if N points at the face.
  double height_m = 0.0;                            ///< Height of x over the plane.
  double own_m = 0.0;                               ///< Amount by which the plane's own depth at x is greater.
};

/// The cover of a cell, the disc around x across N, by a solid, seen along N.
struct CellCover {
  double depth_m = 0.0;                                ///< Depth of the solid behind the cell, along -N.
  double share = 0.0;                                  ///< Fraction of the cell that it covers.
  Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();  ///< Middle of that part.
  std::size_t main = 0;                                ///< The face that covers the most of the cell.
  double own = 0.0;  ///< Weight of the depth of `main` at x in `depth_m`; 1 if it has the whole cell.
};

/// Least cosine (70 degrees) between -N and a face's normal: at smaller ones depth along N says little of distances,
/// and a cell without a face above it is not pressed.
inline constexpr double kSteep = 0.35;

/// Memory of cell_cover().
struct CellWork {
  /// Allocates room for so many faces.
  explicit CellWork(std::size_t faces = 0);

  Polygon around, cell, part, scratch;
};

/// Computes the cover of a cell by the solid below all planes. Along N a point y of the cell meets it at the depth
/// d(y), the least of those of the faces that N points at, unless it passes by. The part of the cell where d > 0 has
/// this share of its area. Its depth is the mean of those weighted with d and with d^2: an elastic half space pressed
/// by a disc of that area to this depth then holds the energy that it has under a cone or a paraboloid within 4 %
/// (Sneddon, Hertz).
///
/// Most cells are covered by one face far around and have its depth at x, whatever part of them is deep: the two depths
/// are blended as an edge approaches from two radii of the cell to one, so that depth and share are continuous in the
/// planes. Where nothing is deep, share is 0, and depth the largest of d, or -infinity where nothing is met.
///
/// Does not allocate where `work` has room.
[[nodiscard]] CellCover cell_cover(std::span<const CellFace> faces, double area_m2, CellWork& work);

}  // namespace thenar
