// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thenar {

/// Hertz's contact of a plane and a body with radii of curvature R_1 >= R_2, relative to that of a sphere of the radius
/// sqrt(R_1 R_2), at the same force [Johnson 1985, 4.2].
struct EllipticHertz {
  double depth = 1.0;   ///< Factor of the approach: F_2 of Johnson, at most 1.
  double size = 1.0;    ///< Factor of the square root of the patch's semi-axes' product: F_1.
  double aspect = 1.0;  ///< The lesser semi-axis of the patch over the larger one, which is along R_1.
};

/// Computes the factors to 1e-9. Requires radii greater than zero, R_1 / R_2 from 1 to 1e4.
[[nodiscard]] EllipticHertz elliptic_hertz(double larger_radius_m, double lesser_radius_m);

}  // namespace thenar
