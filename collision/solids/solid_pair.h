#pragma once

#include <Eigen/Core>
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

}  // namespace thenar
