#pragma once

#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A peg and its hole in a plane.
struct PegShape {
  double radius_m = 0.0, hole_radius_m = 0.0;
  double chamfer_m = 0.0;  ///< Width and height, 45 degrees; 0: none.
  double friction = 0.0;

  /// c = (D - d) / D.
  [[nodiscard]] double clearance() const { return (hole_radius_m - radius_m) / hole_radius_m; }
  /// The tilt below which friction cannot wedge the peg: where it touches two points, their line is steeper than the
  /// friction cones [rad]. Infinite without friction.
  [[nodiscard]] double wedging_tilt_rad() const { return clearance() / friction; }
  /// l below the chamfer at which a peg with this tilt touches two points: theta l = c D.
  [[nodiscard]] double two_point_m(double tilt_rad) const { return 2.0 * (hole_radius_m - radius_m) / tilt_rad; }
};

/// What holds the peg: a spring at a point of its axis, so far above its end.
struct PegSpring {
  double translation_N_per_m = 0.0;
  double rotation_Nm_per_rad = 0.0;
  double above_end_m = 0.0;
};

/// Where the hand wants the peg: the middle of its end, in the hole's plane (x, z up from the plate), and its tilt, by
/// which its upper end leans towards +x.
struct PegPose {
  double x_m = 0.0, z_m = 0.0;
  double tilt_rad = 0.0;
};

/// What the theory says.
struct PegForce {
  double depth_m = 0.0;                                 ///< Of the middle of the peg's end below the plate.
  double push_N = 0.0, aside_N = 0.0, moment_Nm = 0.0;  ///< F_z, F_x, M about that middle: the hand's, on the peg.
  double tilt_rad = 0.0;
  int points = 0;  ///< Contacts.
  bool on_chamfer = false;
};

/// Whitney's theory of a compliant insertion: a rectangle on springs that slides into a slot, without inertia or
/// viscosity. At most two of its points touch chamfer, wall or mouth; each bears N >= 0 and mu N against the way in.
/// The poses are where the hand wants it to be, one after another. Ends where no such forces balance the springs: there
/// the peg does not slide. Small turns: second orders of the tilt are in the gaps, not in the springs.
[[nodiscard]] std::vector<PegForce> peg_theory(const PegShape& shape, const PegSpring& spring,
                                               const std::vector<PegPose>& wanted);

}  // namespace thenar
