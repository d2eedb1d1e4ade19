#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <memory>
#include <variant>
#include <vector>

#include "collision/solids/solid.h"

namespace thenar {

class SampledSolid;

/// What touches a body: an exact solid, or one whose surface samples stand for.
using TouchingSolid = std::variant<Solid, std::shared_ptr<const SampledSolid>>;

/// The radius of the smallest ball about the origin that has the solid in it; infinite for half spaces and holes.
[[nodiscard]] double reach_m(const TouchingSolid& solid);

/// Where two solids A and B touch, or nearly. In B's frame.
struct SolidContact {
  std::int32_t place = 0;  ///< Which feature of one and facet of the other; the same as long as they meet.
  /// Of several contacts at one place, the nearest is the same, if it has gone no farther than this.
  double same_m = std::numeric_limits<double>::infinity();
  double gap_m = 0.0;   ///< Negative: they overlap.
  Eigen::Vector3d p_m;  ///< The feature's point, or that on its round: its motion along n is the gap's.
  Eigen::Vector3d n;    ///< Out of B, into A.
  bool roams = false;   ///< It is at the place of least gap, and goes elsewhere as the solids move.
  // Of one that roams: by how much its gap's slope changes on a way of its feature, at most, infinite where that is not
  // known; and how far from p the feature is, the middle of a round.
  double bend_per_m = 0.0, round_m = 0.0;
};

/// Two solids made ready to look for contacts.
struct SolidPair {
  SolidPair(const TouchingSolid& one, const Solid& other);

  TouchingSolid a;
  Solid b;
  std::vector<Feature> of_a, of_b;
};

/// Most contacts that A can have with B. Where A is sampled there are as many, whatever its samples: it may be null.
[[nodiscard]] std::size_t most_contacts(const TouchingSolid& a, const Solid& b);

/// Adds all contacts whose gap is below `band_m`, A at X_BA: features of A over facets of B, features of B over faces
/// of A, and edges of two boxes that cross. Edges and circles give the places of least gap, to rounding; a circle on a
/// flat face, or one that fits its place to 10 nm, gives 32 points that are fixed on it, for any three of them may
/// carry it: tilted by an angle t, its lowest is off by up to 0.5 % of r sin(t).
///
/// Not found: an edge of a box that crosses the mouth of a hole, unless a face covers the mouth there. Does not
/// allocate where `contacts` has room.
void find_contacts(const SolidPair& pair, const Eigen::Isometry3d& X_BA, double band_m,
                   std::vector<SolidContact>& contacts);

}  // namespace thenar
