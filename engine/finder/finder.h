// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/finder/found_grasp.h"

namespace thenar {

/// Finds grasps of an object by a hand.
///
/// 1. The hand alone: postures in which one finger, the opposer, faces the others across a gap, from closed to as wide
///    as the hand opens (pinch.h). The opposer is the finger with the widest range of these.
/// 2. The object alone: pairs of points whose line lies in the friction cones of both, on patches without edges
///    (oppositions.h).
/// 3. Both: an opposition of the hand is matched with one of the object, at all roll angles about their line. The best
///    are fitted by damped least squares on gaps, facing normals, balance, joint limits, and bones that stay out of the
///    object and of one another; the unknowns are the joints and the object's pose (fit.h).
/// 4. Fits without faults are rated by the forces that the controller would command (rate.h); the best are refined and
///    rated by how far they carry the object (carry.h).
/// If the hand has more than three fingers and all together find nothing, smaller sets are tried.
///
/// Requires  finite numbers, at least one finger.
/// Cost      about 0.2 s for one grasp, three times that for ranks; up to 2 s without a result. Allocates; does not
///           lock or read files.
[[nodiscard]] FinderReport find_grasps(const FinderProblem& problem, const FinderSettings& settings = {},
                                       const FinderProgress& progress = {});

}  // namespace thenar
