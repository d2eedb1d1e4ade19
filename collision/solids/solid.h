#pragma once

#include <Eigen/Core>
#include <optional>
#include <variant>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

// Solids with exact surfaces, each in a frame of its own. Sizes are full sizes; an axis of revolution is z. Samples of
// a surface err by up to h^2 / (8 R) between them, as much as the clearance of a fit: what has to fit is exact.

/// All that is below z = 0.
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
  double chamfer_m = 0.0;  ///< Its width, and height; 0: a sharp mouth. Less than the depth.
  bool operator==(const HoleShape&) const = default;
};
using Solid = std::variant<HalfSpace, BoxShape, SphereShape, CylinderShape, HoleShape>;

/// How a point stands to a facet: `gap_m` above its nearest point of it, which has this normal, out of the solid.
struct Foot {
  enum class On { kFlat, kRound, kEdge };  ///< A face, flat or not; or an edge or a corner.
  double gap_m = 0.0;                      ///< Negative: in the solid.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  On on = On::kFlat;
};

/// A solid's surface in parts that are convex, or so that a point has one nearest point of each. Most solids have one;
/// a hole has its plate, its wall with mouth and chamfer, and its floor.
[[nodiscard]] int facets(const Solid& solid);

/// Where x is over, or not far under, a facet; nothing elsewhere. To rounding.
[[nodiscard]] std::optional<Foot> foot(const Solid& solid, int facet, const Eigen::Vector3d& x);

/// A part of a solid that meets others first: a corner, an edge or a circle, or what is so far from the middle of a
/// round.
struct Feature {
  enum class Kind { kPoint, kSegment, kCircle };
  Kind kind = Kind::kPoint;
  Eigen::Vector3d a_m = Eigen::Vector3d::Zero();  ///< The point; the segment's begin; the circle's middle, about z.
  Eigen::Vector3d b_m = Eigen::Vector3d::Zero();  ///< The segment's end.
  double circle_m = 0.0;                          ///< The circle's radius.
  double round_m = 0.0;                           ///< So far around it the solid's surface is.
};

/// Corners, edges, circles and rounds of a solid: with the faces, all by which it can touch. A half space has none.
[[nodiscard]] std::vector<Feature> features(const Solid& solid);

/// The radius of the smallest ball about the origin that has the solid in it; infinite for half spaces and holes.
[[nodiscard]] double reach_m(const Solid& solid);

}  // namespace thenar
