// SPDX-License-Identifier: Apache-2.0
#include "engine/control/pose_gains.h"

#include <cstddef>
#include <iterator>

namespace thenar {

PoseGains PoseGains::times(double of_position, double of_rotation) const {
  const auto scaled = [](const PidGains& gains, double by) {
    return PidGains{by * gains.p, by * gains.i, by * gains.d};
  };
  return {scaled(position, of_position), scaled(rotation, of_rotation), centre_m};
}

PoseGains pose_gains(const Scene& scene, int phase) {
  const ControlSettings& control = *scene.control;
  const auto& phases = scene.task.phases;
  PoseGains gains{control.position, control.rotation, control.centre_m};
  if (phase < 0 || phase >= std::ssize(phases)) return gains;
  const Phase* own = &phases[static_cast<std::size_t>(phase)];
  if (phase > 0 && own->kind == Phase::Kind::kPlace && own[-1].kind == Phase::Kind::kInsert) --own;
  if (own->position) gains.position = *own->position;
  if (own->rotation) gains.rotation = *own->rotation;
  if (own->centre_m) gains.centre_m = own->centre_m;
  return gains;
}

}  // namespace thenar
