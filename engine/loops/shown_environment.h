// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string_view>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/loops/picture.h"

namespace thenar {

/// A solid's name and sizes: "plane", "box", "sphere", "cylinder" or "hole".
struct ShownSolid {
  std::string_view shape;
  /// Sizes: of a box along x, y, z; the radius of a sphere; radius and length of a cylinder; radius, depth and chamfer
  /// of a hole [m]; else 0.
  std::array<double, 3> size_m{};
};
[[nodiscard]] ShownSolid shown_solid(const Solid& solid);

inline constexpr std::size_t kMostTouches = 64;  ///< Largest number of shown contacts with the environment.

/// The environment for display, at one instant; world axes. NaN: no value.
struct ShownEnvironment {
  std::vector<Eigen::Isometry3d> X_WE;  ///< One per body, as the columns of the next two.
  Eigen::Matrix3Xd force_N, mean_m;  ///< Sum of forces on the object; mean of their points, weighted by normal force.

  // The contacts with the largest forces, a column each; as many as the environment can have, at most kMostTouches.
  Eigen::Matrix3Xd point_m, touch_N;
  Eigen::VectorXd margin;  ///< 1: no friction; 0: on the cone.
};

/// Returns the environment for display; requires a scene with an environment.
[[nodiscard]] ShownEnvironment shown_environment(const Model& model, const Picture& picture);

}  // namespace thenar
