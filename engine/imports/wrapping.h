// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A sphere, or an infinite cylinder about z, that a tendon may touch.
struct WrapSurface {
  double radius_m = 0.0;
  bool is_cylinder = false;
};

/// Finds the points where a taut string from a to b meets and leaves a surface, all in the surface's frame; nothing if
/// it is straight. `side`, if given, selects the side of the surface; a side inside of it, as seen across the plane of
/// the string, makes the string pass through the surface as through a ring. A string that begins or ends inside is
/// straight. Choices among several paths are those of MuJoCo, whose models are read.
[[nodiscard]] std::optional<std::array<Eigen::Vector3d, 2>> wrap(const WrapSurface& surface, const Eigen::Vector3d& a,
                                                                 const Eigen::Vector3d& b,
                                                                 const std::optional<Eigen::Vector3d>& side);

}  // namespace thenar
