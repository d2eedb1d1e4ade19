// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "engine/hand/hand.h"
#include "engine/imports/tendon_route.h"

namespace thenar {

/// Converts a straight span to crossings with the same moment arms.
[[nodiscard]] std::vector<MuscleCrossing> crossings_of(const Hand& hand, const RouteSpan& span);

/// Fits crossings to a span that wraps a surface, with moment arms near those of the span over the joints' ranges.
/// Where via points on the tendon's path fit well, they serve all joints, so that the arms remain derivatives of one
/// length; a joint with an error above 0.3 mm rms then gets its own points, or a constant arm.
[[nodiscard]] std::vector<MuscleCrossing> fit_crossings(const Hand& hand, const RouteSpan& span);

/// Draws random postures that fill the joints' ranges.
[[nodiscard]] std::vector<HandPose> random_poses(const Hand& hand, int number, std::uint64_t seed);

}  // namespace thenar
