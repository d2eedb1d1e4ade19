#pragma once

#include "engine/grasp/scene.h"
#include "engine/scenes/config.h"

namespace thenar {

/// What the map `control` of a scene says; `pressed`: a grasp that is found says how hard the fingers squeeze;
/// `feels`: the fingertips do.
[[nodiscard]] ControlSettings read_control(const ConfigMap& map, const Hand& hand, bool pressed, bool feels);

[[nodiscard]] PidGains read_gains(const ConfigMap& map);

/// Its table `drive`, for this hand. False if the file cannot be read, which is reported.
bool read_drive(const ConfigMap& map, const Hand& hand, ControlSettings& control);

}  // namespace thenar
