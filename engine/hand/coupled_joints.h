#pragma once

#include <span>
#include <string>

#include "engine/hand/hand.h"

namespace thenar {

/// One joint of a hand turns with another one of its finger: q_joint = ratio q_leader + offset. What is left as q are
/// the joints that turn by themselves: all angles are S q + q0, and all that acts on the joints, such as J' f, g and
/// H f_m, acts on q by S'. Each joint has its finger's viscosity b, so that a leader has S' b S = b (1 + sum of
/// ratio^2): Joint::drag.
struct Coupling {
  int joint = 0, leader = 0;
  double ratio = 1.0, offset_rad = 0.0;
};

/// What is wrong with the last of these couplings of a hand whose joints all turn by themselves, in words; empty if it
/// fits to those before it.
[[nodiscard]] std::string coupling_fault(const Hand& hand, std::span<const Coupling> couplings);

/// The hand in which these joints follow others. A leader keeps to the limits of its followers, too.
[[nodiscard]] Hand coupled(Hand hand, std::span<const Coupling> couplings);

}  // namespace thenar
