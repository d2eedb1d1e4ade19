#pragma once

#include <Eigen/Geometry>
#include <numbers>
#include <string>

#include "engine/imports/mjcf_defaults.h"

namespace thenar {

/// How an MJCF file writes angles.
struct MjcfAngles {
  double unit_rad = std::numbers::pi / 180.0;  ///< Degrees, unless the compiler says otherwise.
  std::string euler = "xyz";                   ///< Axes that turn along in small letters, fixed ones in capitals.
};

[[nodiscard]] MjcfAngles angles_of(const XmlElement& mujoco, const MjcfDefaults& defaults);

/// The pose that an element's `pos` and one of quat, axisangle, xyaxes, zaxis and euler give. Throws ConfigError.
[[nodiscard]] Eigen::Isometry3d pose_of(const XmlElement& element, const MjcfAngles& angles);

}  // namespace thenar
