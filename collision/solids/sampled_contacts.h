#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "collision/solids/sampled_solid.h"
#include "collision/solids/solid_pair.h"

namespace thenar {

/// Most contacts with a body: of edges and corners, and of each facet's round places; the body's own features add.
inline constexpr std::size_t kMostSharp = 32, kMostRound = 24;

/// As find_contacts, of a solid A that samples stand for. Where it is round it touches at the places of least gap of
/// the bent surfaces around its samples, the mean of those that share a place; with its edges and corners, of which so
/// many count as are farthest from one another, and the deepest; and everywhere with the corners, edges and circles of
/// B, over the surface that the samples make.
void find_sampled_contacts(const SampledSolid& a, const SolidPair& pair, const Eigen::Isometry3d& X_BA, double band_m,
                           std::vector<SolidContact>& contacts);

}  // namespace thenar
