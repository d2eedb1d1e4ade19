// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/imports/body_tree.h"
#include "engine/imports/mjcf_pose.h"

namespace thenar {

/// A geom of an MJCF file, in the frame of its body.
struct MjcfGeom {
  std::string type;
  Eigen::Isometry3d X_BG;
  double radius_m = 0.0;           ///< The first number of its size.
  std::optional<double> mass_kg;   ///< Nothing for meshes and the like, whose volume is not in the file.
  std::optional<TreeRound> round;  ///< Shape of a sphere, an ellipsoid or a capsule.
};

/// Reads a geom completed by its class; `X_BF` is its enclosing frame. Throws ConfigError.
[[nodiscard]] MjcfGeom read_geom(const XmlElement& geom, const MjcfAngles& angles, const Eigen::Isometry3d& X_BF);

}  // namespace thenar
