// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "engine/hand/hand.h"

namespace thenar {

/// The coupling of a joint to another one of its finger: q_joint = ratio q_leader + offset. The independent joints
/// remain as q: all angles are S q + q0, and all torques on the joints, such as J' f, g and H f_m, act on q by S'. Each
/// joint has its finger's viscosity b, so that a leader has S' b S = b (1 + sum of ratio^2): Joint::drag.
struct Coupling {
  int joint = 0, leader = 0;
  double ratio = 1.0, offset_rad = 0.0;
};

/// Describes the fault of the last of these couplings of a hand whose joints are all independent; empty if it is
/// consistent with those before it.
[[nodiscard]] std::string coupling_fault(const Hand& hand, std::span<const Coupling> couplings);

/// Returns the hand with these couplings. A leader is also limited by the limits of its followers.
[[nodiscard]] Hand coupled(Hand hand, std::span<const Coupling> couplings);

}  // namespace thenar
