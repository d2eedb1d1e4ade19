// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A peg and its hole in a plane.
struct PegShape {
  double radius_m = 0.0, hole_radius_m = 0.0;
  double chamfer_m = 0.0;  ///< Width and height, 45 degrees; 0: none.
  double friction = 0.0;

  /// Returns c = (D - d) / D.
  [[nodiscard]] double clearance() const { return (hole_radius_m - radius_m) / hole_radius_m; }
  /// Returns the tilt below which friction cannot wedge the peg: the line through its two contacts is then steeper than
  /// the friction cones [rad]. Infinite without friction.
  [[nodiscard]] double wedging_tilt_rad() const { return clearance() / friction; }
  /// Returns l below the chamfer at which a peg with this tilt touches two points: theta l = c D.
  [[nodiscard]] double two_point_m(double tilt_rad) const { return 2.0 * (hole_radius_m - radius_m) / tilt_rad; }
};

/// The support of the peg: a spring at a point of its axis, `above_end_m` above its end.
struct PegSpring {
  double translation_N_per_m = 0.0;
  double rotation_Nm_per_rad = 0.0;
  double above_end_m = 0.0;
};

/// The commanded pose of the peg: the middle of its end, in the hole's plane (x, z up from the plate), and its tilt of
/// the upper end towards +x.
struct PegPose {
  double x_m = 0.0, z_m = 0.0;
  double tilt_rad = 0.0;
};

/// The result of the theory.
struct PegForce {
  double depth_m = 0.0;                                 ///< Depth of the middle of the peg's end below the plate.
  double push_N = 0.0, aside_N = 0.0, moment_Nm = 0.0;  ///< F_z, F_x, M about that middle, of the hand on the peg.
  double tilt_rad = 0.0;
  int points = 0;  ///< Number of contacts.
  bool on_chamfer = false;
};

/// Computes Whitney's theory of a compliant insertion: a rectangle on springs that slides into a slot, without inertia
/// or viscosity. At most two of its points touch chamfer, wall or mouth; each bears N >= 0 and mu N against the
/// insertion. The poses are the commanded ones, in sequence. The result ends where no such forces balance the springs
/// and the peg does not slide. For small rotations: second orders of the tilt are in the gaps, not in the springs.
[[nodiscard]] std::vector<PegForce> peg_theory(const PegShape& shape, const PegSpring& spring,
                                               const std::vector<PegPose>& wanted);

}  // namespace thenar
