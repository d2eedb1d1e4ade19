// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "collision/solids/solid_pair.h"

namespace thenar {

/// Returns the largest number of contacts of A with B, independent of a sampled A's samples: it may be null.
[[nodiscard]] std::size_t most_contacts(const TouchingSolid& a, const Solid& b);

/// Adds all contacts whose gap is below `band_m`, A at X_BA: features of A over facets of B, features of B over faces
/// of A, and crossing edges of two boxes: with the corners, they are the corners of the area that two faces share.
/// Edges and circles give the points of least gap, to rounding. A circle on a flat face, or one that fits to 10 nm,
/// gives 32 points that are fixed on it, for any three of them may carry it; where it is tilted over the face, its
/// lowest point replaces the two beside it. One that fits to 1 mm, as a peg's end in its hole, gives these besides its
/// points of least gap, except the neighbours of those.
///
/// Not found: an edge of a box that crosses the mouth of a hole, unless a face covers the mouth there. Does not
/// allocate where `contacts` has room.
void find_contacts(const SolidPair& pair, const Eigen::Isometry3d& X_BA, double band_m,
                   std::vector<SolidContact>& contacts);

}  // namespace thenar
