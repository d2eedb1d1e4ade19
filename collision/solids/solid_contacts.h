#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "collision/solids/solid.h"

namespace thenar {

/// Where two solids A and B touch, or nearly. In B's frame.
struct SolidContact {
  std::int32_t place = 0;  ///< Which feature of one and facet of the other; the same as long as they meet.
  double angle_rad = 0.0;  ///< On a circle, where: of several contacts at one place, the nearest is the same.
  double gap_m = 0.0;      ///< Negative: they overlap.
  Eigen::Vector3d p_m;     ///< The feature's point, or that on its round: its motion along n is the gap's.
  Eigen::Vector3d n;       ///< Out of B, into A.
};

/// Two solids made ready to look for contacts.
struct SolidPair {
  SolidPair(const Solid& one, const Solid& other);

  Solid a, b;
  std::vector<Feature> of_a, of_b;
};

/// Most contacts that a pair can have.
[[nodiscard]] std::size_t most_contacts(const SolidPair& pair);

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
