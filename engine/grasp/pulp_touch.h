// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "collision/implicit_surface.h"
#include "engine/hand/hand.h"

namespace thenar {

/// A sphere about a point of the distal frame.
struct PulpBall {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
};

/// Returns the ball that a pulp resembles where it is nearest to an object: their surfaces touch there. So the ball's
/// distance from the object is the pulp's, and changes as it does with every motion of them. A spherical pulp is this
/// ball.
///
/// For an ellipsoid its radius is the mean of the two radii of curvature there, and not more than the largest
/// semi-axis. The place found turns with the object's normal until the two agree: a place of least distance near the
/// direction of the object, not always the least one of all. For a capsule it is the least one along its line; a
/// capsule that lies flat on a face, to 1 degree, touches it where its line would if it bulged a little: in the middle
/// if it lies quite flat. Does not allocate.
[[nodiscard]] PulpBall touching_ball(const Fingertip& tip, const ImplicitSurface& object,
                                     const Eigen::Isometry3d& X_OF);

/// Returns the place of the pulp's surface nearest to a point of the distal frame, likewise there.
[[nodiscard]] PulpPlace nearest_place(const Fingertip& tip, const Eigen::Vector3d& x_F);

/// Returns the pulp's extent from its centre in the direction n (unit), distal frame; and the largest one.
[[nodiscard]] double extent_m(const Fingertip& tip, const Eigen::Vector3d& n);
[[nodiscard]] double outer_radius_m(const Fingertip& tip);

/// Returns the radius of the sphere that a plane across the pulp's normal presses in about as far, with the same force:
/// the geometric mean of the two radii of curvature [Johnson 1985, 4.2].
[[nodiscard]] double round_radius_m(const Fingertip& tip);

}  // namespace thenar
