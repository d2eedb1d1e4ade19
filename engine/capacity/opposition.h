// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/hand/hand.h"

namespace thenar {

/// Two fingers whose pulps can face each other, with the range of widths between them.
struct FacingFingers {
  int one = 0, other = 0;              ///< Fingers, the first before the second.
  double least_m = 0.0, most_m = 0.0;  ///< Free space between the pulps.
};

/// Finds the pairs of fingers that can face each other within their joints' ranges: each pulp's normal is within 30
/// degrees of the line to the other, which a friction of 0.6 allows. It samples 1500 postures per finger, so that
/// widths are some millimetres too small.
[[nodiscard]] std::vector<FacingFingers> find_oppositions(const Hand& hand);

}  // namespace thenar
