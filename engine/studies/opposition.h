#pragma once

#include <vector>

#include "engine/hand/hand.h"

namespace thenar {

/// Two fingers whose pulps can face each other, and how wide what they hold between them may be.
struct Opposition {
  int one = 0, other = 0;              ///< Fingers, the first before the second.
  double least_m = 0.0, most_m = 0.0;  ///< Free space between the pulps.
};

/// The pairs of fingers that can face each other within their joints' ranges: each pulp's normal is within 30 degrees
/// of the line to the other, which friction of 0.6 allows. Found on 1500 postures a finger, so that widths are short of
/// the true ones by some millimetres.
[[nodiscard]] std::vector<Opposition> find_oppositions(const Hand& hand);

}  // namespace thenar
