// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "engine/hand/hand.h"
#include "thenar/eigen_layout.h"

// Elements that pictures are painted with: small discs of surfaces, the far ones first.

namespace thenar {

/// Colours: red, green, blue in 0 .. 1.
inline const Eigen::Vector3d kBone{0.86, 0.80, 0.70};
inline const Eigen::Vector3d kSkin{0.93, 0.72, 0.62};

/// Gnuplot style for the output of painted().
inline constexpr const char* kDiscs = "using 1:2:3:4 with circles lc rgb variable";

/// A small disc of a surface.
struct Surfel {
  Eigen::Vector3d point_m, normal, color;  // World axes; color red, green, blue in 0 .. 1.
  double radius_m;
};

/// Adds a sphere.
void add_ball(const Eigen::Vector3d& centre_m, double radius_m, const Eigen::Vector3d& color,
              std::vector<Surfel>& surfels);

/// Adds a rigid pulp; X_WF is the pose of its segment.
void add_rigid_pulp(const Fingertip& tip, const Eigen::Isometry3d& X_WF, std::vector<Surfel>& surfels);

/// Adds bones from joint to joint, and from the wrist to each finger.
void add_bones(const Hand& hand, const HandPose& pose, std::vector<Surfel>& surfels);

/// Far discs first, each as "x y radius colour" [mm]. Rows of `view`: right, up, towards the eye.
[[nodiscard]] std::string painted(std::vector<Surfel> surfels, const Eigen::Matrix3d& view);

}  // namespace thenar
