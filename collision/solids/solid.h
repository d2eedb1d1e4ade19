// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <variant>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

// Solids with exact surfaces, each in a frame of its own. Sizes are full sizes; an axis of revolution is z. Samples of
// a surface err by up to h^2 / (8 R) between them, as much as the clearance of a fit: parts that must fit are exact.

/// The half space z < 0.
struct HalfSpace {
  bool operator==(const HalfSpace&) const = default;
};
struct BoxShape {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  ///< Along x, y, z; centred on the origin.
  bool operator==(const BoxShape&) const = default;
};
struct SphereShape {
  double radius_m = 0.0;
  bool operator==(const SphereShape&) const = default;
};
struct CylinderShape {
  double radius_m = 0.0, length_m = 0.0;  ///< Centred on the origin.
  bool operator==(const CylinderShape&) const = default;
};
/// A half space with a blind hole about z, whose mouth at z = 0 may have a chamfer of 45 degrees.
struct HoleShape {
  double radius_m = 0.0, depth_m = 0.0;
  double chamfer_m = 0.0;  ///< Width and height of the chamfer, less than the depth; 0: a sharp mouth.
  bool operator==(const HoleShape&) const = default;
};
using Solid = std::variant<HalfSpace, BoxShape, SphereShape, CylinderShape, HoleShape>;

/// The foot of a point on a facet: the point is `gap_m` above it along this outward normal.
struct Foot {
  enum class On { kFlat, kRound, kEdge };  ///< A flat face, a curved face, or an edge or corner.
  double gap_m = 0.0;                      ///< Gap; negative inside the solid.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  On on = On::kFlat;
};

/// Returns the number of facets, parts of a solid's surface that are convex, or on which nearest points are unique.
/// Most solids have one; a hole has its plate, its wall with mouth and chamfer, and its floor.
[[nodiscard]] int facets(const Solid& solid);

/// Finds the foot of x if it is over, or not far under, a facet, to rounding; nothing elsewhere.
[[nodiscard]] std::optional<Foot> foot(const Solid& solid, int facet, const Eigen::Vector3d& x);

/// A part of a solid that meets others first: a corner, an edge or a circle, or a rounding about these.
struct Feature {
  enum class Kind { kPoint, kSegment, kCircle };
  Kind kind = Kind::kPoint;
  Eigen::Vector3d a_m = Eigen::Vector3d::Zero();  ///< The point; the segment's begin; the circle's middle, about z.
  Eigen::Vector3d b_m = Eigen::Vector3d::Zero();  ///< The segment's end.
  double circle_m = 0.0;                          ///< The circle's radius.
  double round_m = 0.0;                           ///< Distance from it to the solid's surface.
};

/// Returns the corners, edges, circles and roundings of a solid: with faces, all that can touch. A half space has none.
[[nodiscard]] std::vector<Feature> features(const Solid& solid);

/// Returns the radius of the smallest ball about the origin around the solid; infinite for half spaces and holes.
[[nodiscard]] double reach_m(const Solid& solid);

}  // namespace thenar
