#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A sphere, or a cylinder about z without an end, that a tendon may touch.
struct WrapSurface {
  double radius_m = 0.0;
  bool is_cylinder = false;
};

/// Where a taut string from a to b meets a surface and leaves it, all in the surface's frame; nothing if it goes
/// straight. `side`, if there is one, says on which side of the surface the string goes; a side inside of it, as
/// seen across the plane of the string, makes the string go through the surface as through a ring. A string that begins
/// or ends inside of it goes straight. The choices among several ways are those of MuJoCo, whose models are read.
[[nodiscard]] std::optional<std::array<Eigen::Vector3d, 2>> wrap(const WrapSurface& surface, const Eigen::Vector3d& a,
                                                                 const Eigen::Vector3d& b,
                                                                 const std::optional<Eigen::Vector3d>& side);

}  // namespace thenar
