#pragma once

#include <cstdint>
#include <vector>

#include "engine/hand/hand.h"
#include "engine/imports/tendon_route.h"

namespace thenar {

/// A straight span as crossings, which have the same moment arms.
[[nodiscard]] std::vector<MuscleCrossing> crossings_of(const Hand& hand, const RouteSpan& span);

/// Crossings for a span that wraps a surface, with moment arms near those of the span over the joints' ranges. Where
/// points that the tendon passes serve well, they are taken for all joints, so that the arms stay the slopes of one
/// length; a joint that is off by more than 0.3 mm rms then gets points of its own, or a constant arm.
[[nodiscard]] std::vector<MuscleCrossing> fit_crossings(const Hand& hand, const RouteSpan& span);

/// Postures that fill the joints' ranges, from a seed.
[[nodiscard]] std::vector<HandPose> random_poses(const Hand& hand, int number, std::uint64_t seed);

}  // namespace thenar
