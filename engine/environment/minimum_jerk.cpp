// SPDX-License-Identifier: Apache-2.0
#include "engine/environment/minimum_jerk.h"

#include <algorithm>

namespace thenar {

double minimum_jerk(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

double minimum_jerk_rate(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return 30.0 * s * s * (1.0 - s) * (1.0 - s);
}

}  // namespace thenar
