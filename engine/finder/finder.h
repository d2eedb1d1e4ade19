#pragma once

#include "engine/finder/found_grasp.h"

namespace thenar {

/// Finds how a hand can hold an object.
///
/// 1. The hand alone: postures in which one finger, the opposer, faces the others across a gap, from closed to as wide
///    as the hand opens (pinch.h). The opposer is the finger that does so over the widest range.
/// 2. The object alone: pairs of places whose line lies in the friction cones of both, on patches without edges
///    (oppositions.h).
/// 3. Both: an opposition of the hand is laid on one of the object, at all rolls about their line. The best are fitted
///    by damped least squares on gaps, facing normals, balance, joint limits, and bones that stay out of the object
///    and of one another; joints and the object's pose are the unknowns (fit.h).
/// 4. What fits is rated by the forces that the controller would ask for (rate.h), the best are polished, and of these
///    it is seen how far they carry the object (carry.h).
/// If the hand has more than three fingers and all together find nothing, smaller sets are tried.
///
/// Requires  finite numbers, at least one finger.
/// Cost      about 0.2 s for one grasp, three times that for ranks; up to 2 s before it gives up. Allocates; does not
///           lock or read files.
[[nodiscard]] FinderReport find_grasps(const FinderProblem& problem, const FinderSettings& settings = {},
                                       const FinderProgress& progress = {});

}  // namespace thenar
