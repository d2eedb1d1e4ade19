#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "collision/polygon.h"

namespace thenar {

/// A plane of a solid that is convex there, beside a place x of another surface with the unit normal N, out of that
/// surface.
struct CellFace {
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< The plane's outward normal, as far as it is across N.
  double facing = 0.0;                              ///< And along -N: > 0 of a face that N points at.
  double height_m = 0.0;                            ///< Of x over the plane.
  double own_m = 0.0;                               ///< What the plane's own depth at x is greater by.
};

/// How a solid covers a cell, the disc around x across N, seen along N.
struct CellCover {
  double depth_m = 0.0;  ///< How far the solid reaches into what is behind the cell, along -N.
  double share = 0.0;    ///< What part of the cell it reaches into.
  Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();  ///< Of that part.
  std::size_t main = 0;                                ///< The face that has the most of the cell.
  double own = 0.0;  ///< How much of `depth_m` is that of `main` at x itself; 1 if it has the whole cell.
};

/// Where N is so nearly along a face (a cosine, 70 degrees), depth along N says little of what is near: a cell that
/// looks at no face at less is not one that they press.
inline constexpr double kSteep = 0.35;

/// What cell_cover() works in.
struct CellWork {
  /// With room for so many faces.
  explicit CellWork(std::size_t faces = 0);

  Polygon around, cell, part, scratch;
};

/// The solid is what lies under all planes. Along N a place y of the cell meets it at the depth d(y), the least of
/// those of the faces that N points at, unless it passes by. The part of the cell where d > 0 has this share of its
/// area. Its depth is the mean of those weighed with d and with d^2: with it an elastic half space that is pressed
/// there as a disc of that area holds the energy which it has under a cone or a paraboloid within 4 % (Sneddon, Hertz).
///
/// A cell that one face covers far around, as most are, has the depth of that face at x, whatever part of it is deep:
/// what both say goes over into one another as an edge comes from two radii of the cell to one. So depth and share are
/// continuous in the planes. Where nothing is deep, share is 0, and depth the largest of d, or -infinity where nothing
/// is met.
///
/// Does not allocate where `work` has room.
[[nodiscard]] CellCover cell_cover(std::span<const CellFace> faces, double area_m2, CellWork& work);

}  // namespace thenar
