// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <numbers>
#include <optional>
#include <string>

#include "engine/imports/mjcf_defaults.h"

namespace thenar {

/// The conventions of angles in an MJCF file.
struct MjcfAngles {
  double unit_rad = std::numbers::pi / 180.0;  ///< Degrees, unless the compiler sets another unit.
  std::string euler = "xyz";                   ///< Intrinsic axes in small letters, extrinsic ones in capitals.
};

[[nodiscard]] MjcfAngles angles_of(const XmlElement& mujoco, const MjcfDefaults& defaults);

/// Where the two points of `fromto` put a geom or a site, which take no other pose then.
struct MjcfEnds {
  Eigen::Isometry3d X_FG;  ///< At the middle; z points to the first one.
  double half_m = 0.0;     ///< Half of their distance.
};

/// Returns what `fromto` says, for an element of this type: capsules, cylinders, ellipsoids and boxes may have one.
/// Nothing if it is missing. Throws ConfigError.
[[nodiscard]] std::optional<MjcfEnds> ends_of(const XmlElement& element, const std::string& type);

/// Refuses an element that names two orientations itself, before its class gives it any.
void expect_one_orientation(const XmlElement& element);

/// Returns the pose by an element's `pos` and one of quat, axisangle, xyaxes, zaxis and euler. Any of the others
/// replaces `quat`, also where the class names one and the element the other. Throws ConfigError.
[[nodiscard]] Eigen::Isometry3d pose_of(const XmlElement& element, const MjcfAngles& angles);

}  // namespace thenar
