#pragma once

#include "engine/imports/body_tree.h"
#include "engine/imports/mjcf_pose.h"

namespace thenar {

/// A geom of an MJCF file, in the frame of its body.
struct MjcfGeom {
  std::string type;
  Eigen::Isometry3d X_BG;
  double radius_m = 0.0;           ///< The first number of its size.
  std::optional<double> mass_kg;   ///< Nothing: of a mesh or the like, whose volume the file does not say.
  std::optional<TreeRound> round;  ///< Of a sphere, an ellipsoid and a capsule.
};

/// Reads a geom that its class has completed; `X_BF` is the frame that it stands in. Throws ConfigError.
[[nodiscard]] MjcfGeom read_geom(const XmlElement& geom, const MjcfAngles& angles, const Eigen::Isometry3d& X_BF);

}  // namespace thenar
