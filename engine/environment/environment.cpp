// SPDX-License-Identifier: Apache-2.0
#include "engine/environment/environment.h"

#include "engine/environment/minimum_jerk.h"

namespace thenar {

Eigen::Vector3d arm_m(const ArmWay& way, double time_s) {
  return way.from_m + minimum_jerk((time_s - way.begin_s) / way.over_s) * way.by_m;
}

void follow(const ArmOrder& order, double now_s, ArmWay& way) {
  if (order.number <= way.order) return;
  way = {order.number, arm_m(way, now_s), order.by_m, now_s, order.over_s};
}

Eigen::Isometry3d pose(const EnvironmentBody& body, const Instant& at) {
  Eigen::Isometry3d X_WE = body.X_WE;
  for (const EnvironmentMove& move : body.moves)
    X_WE.translation() += minimum_jerk((at.time_s - move.from_s) / move.over_s) * move.by_m;
  X_WE.translation() -= at.arm_m;
  return X_WE;
}

}  // namespace thenar
