#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string_view>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/loops/picture.h"

namespace thenar {

/// A solid in few words: "plane", "box", "sphere", "cylinder" or "hole".
struct ShownSolid {
  std::string_view shape;
  /// Of a box along x, y, z; the radius of a sphere; radius and length of a cylinder; radius, depth and chamfer of a
  /// hole [m]. The rest is 0.
  std::array<double, 3> size_m{};
};
[[nodiscard]] ShownSolid shown_solid(const Solid& solid);

inline constexpr std::size_t kMostTouches = 64;  ///< Of the contacts with the environment, those that are shown.

/// The environment for eyes, at one instant; world axes. NaN: nothing is there.
struct ShownEnvironment {
  std::vector<Eigen::Isometry3d> X_WE;  ///< A body each, as the columns of the next two.
  Eigen::Matrix3Xd force_N, mean_m;     ///< Sum on the object; mean of its points, by normal force.

  // The contacts with the most force, a column each. As many as the environment can have, at most kMostTouches.
  Eigen::Matrix3Xd point_m, touch_N;
  Eigen::VectorXd margin;  ///< 1: no friction; 0: on the cone.
};

/// Of a scene that has an environment.
[[nodiscard]] ShownEnvironment shown_environment(const Model& model, const Picture& picture);

}  // namespace thenar
