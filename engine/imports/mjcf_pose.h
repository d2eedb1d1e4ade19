#pragma once

#include <Eigen/Geometry>
#include <numbers>
#include <string>

#include "engine/imports/mjcf_defaults.h"

namespace thenar {

/// The conventions of angles in an MJCF file.
struct MjcfAngles {
  double unit_rad = std::numbers::pi / 180.0;  ///< Degrees, unless the compiler sets another unit.
  std::string euler = "xyz";                   ///< Intrinsic axes in small letters, extrinsic ones in capitals.
};

[[nodiscard]] MjcfAngles angles_of(const XmlElement& mujoco, const MjcfDefaults& defaults);

/// Returns the pose by an element's `pos` and one of quat, axisangle, xyaxes, zaxis and euler. Throws ConfigError.
[[nodiscard]] Eigen::Isometry3d pose_of(const XmlElement& element, const MjcfAngles& angles);

}  // namespace thenar
