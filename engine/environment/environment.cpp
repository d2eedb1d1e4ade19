#include "engine/environment/environment.h"

#include <algorithm>

namespace thenar {

double minimum_jerk(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

Eigen::Isometry3d pose(const EnvironmentBody& body, double time_s) {
  Eigen::Isometry3d X_WE = body.X_WE;
  for (const EnvironmentMove& move : body.moves)
    X_WE.translation() += minimum_jerk((time_s - move.from_s) / move.over_s) * move.by_m;
  return X_WE;
}

}  // namespace thenar
