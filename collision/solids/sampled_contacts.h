// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "collision/solids/sampled_solid.h"
#include "collision/solids/solid_pair.h"

namespace thenar {

/// Largest numbers of contacts with a body: of edges and corners, and of each facet's round places; the body's own
/// features add to them.
inline constexpr std::size_t kMostSharp = 32, kMostRound = 24;

/// Finds contacts as find_contacts does, for a sampled solid A. Where it is curved it touches at the points of least
/// gap of the curved surfaces around its samples, averaged where they share a place; with its edges and corners, up to
/// kMostSharp that are farthest from one another, and the deepest; and everywhere with the corners, edges and circles
/// of B, over the surface of the samples.
void find_sampled_contacts(const SampledSolid& a, const SolidPair& pair, const Eigen::Isometry3d& X_BA, double band_m,
                           std::vector<SolidContact>& contacts);

}  // namespace thenar
