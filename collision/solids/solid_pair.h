// SPDX-License-Identifier: Apache-2.0
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

/// A solid that touches a body: exact, or sampled.
using TouchingSolid = std::variant<Solid, std::shared_ptr<const SampledSolid>>;

/// Returns the radius of the smallest ball about the origin around the solid; infinite for half spaces and holes.
[[nodiscard]] double reach_m(const TouchingSolid& solid);

/// A contact, or near contact, of two solids A and B, in B's frame.
struct SolidContact {
  std::int32_t place = 0;  ///< Identifies the feature of one and the facet of the other, as long as they meet.
  /// Of several contacts at one place, the nearest one counts as the same if it has moved no farther than this.
  double same_m = std::numeric_limits<double>::infinity();
  double gap_m = 0.0;   ///< Gap; negative: they overlap.
  Eigen::Vector3d p_m;  ///< The feature's point, or the point on its rounding: its motion along n changes the gap.
  Eigen::Vector3d n;    ///< Normal out of B, into A.
  bool roams = false;   ///< True if it is at the point of least gap, which shifts as the solids move.
  // For one that roams: largest change of its gap's slope per displacement of its feature, infinite if not known; and
  // the distance from p to the feature, the middle of a rounding.
  double bend_per_m = 0.0, round_m = 0.0;
};

/// Two solids prepared for the search for contacts.
struct SolidPair {
  SolidPair(const TouchingSolid& one, const Solid& other);

  TouchingSolid a;
  Solid b;
  std::vector<Feature> of_a, of_b;
};

}  // namespace thenar
