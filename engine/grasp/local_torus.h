// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/grasp/lanes.h"

namespace thenar {

/// The object's surface around a contact's surface point, as a FrameContact has it: of one contact (double), or in all
/// lanes. Its parts are in the object frame.
template <typename Number>
struct LocalTorus {
  lanes::VectorOf<Number> n, t;   ///< Normal into the object, and the direction of the tube, across n.
  Number tube_per_m, ring_per_m;  ///< Curvatures, > 0 convex; 0 of a plane and a rod.
};

/// The signed distance of a point from a torus, and the torus's normal into the object at the point's foot; at a centre
/// of curvature it is shorter than 1.
template <typename Number>
struct TorusGap {
  Number gap_m;
  lanes::VectorOf<Number> n;
};

/// Tells where a point is to a circle of curvature k that goes through the origin, from which it is `over_m` above the
/// tangent and off the normal by a length with this square: (R + gap)^2 = (R + over)^2 + off^2, solved for the gap
/// without a difference of large numbers.
template <typename Number>
struct OverCircle {
  OverCircle(Number k_per_m, Number over_m, Number off_m2) {
    constexpr double kLeast = 1e-12;  // At the centre there is no normal.
    const Number a = 2.0 * over_m + k_per_m * (over_m * over_m + off_m2);
    root = lanes::root(lanes::at_least(kLeast, 1.0 + k_per_m * a));
    gap_m = a / (1.0 + root);
  }
  Number root;  ///< Its distance from the circle's centre, in radii.
  Number gap_m;
};

/// Computes the gap of a point. `to_surface_m` leads from the point to the contact's surface point, object frame. It is
/// inlined in the lanes' loop, where a call would store them all.
template <typename Number>
[[gnu::always_inline]] inline TorusGap<Number> gap_to(const LocalTorus<Number>& torus,
                                                      const lanes::VectorOf<Number>& to_surface_m) {
  // In the plane of n and n x t the ring is a circle, over which the point is `gap_m` with the normal m. In the plane
  // of m and t the tube is one.
  const Number over_m = lanes::dot(torus.n, to_surface_m), along_m = lanes::dot(torus.t, to_surface_m);
  lanes::VectorOf<Number> across_m;
  for (int r = 0; r < 3; ++r) across_m[r] = to_surface_m[r] - over_m * torus.n[r] - along_m * torus.t[r];
  const OverCircle<Number> ring(torus.ring_per_m, over_m, lanes::dot(across_m, across_m));
  const OverCircle<Number> tube(torus.tube_per_m, ring.gap_m, along_m * along_m);
  const Number of_m = (1.0 + torus.tube_per_m * ring.gap_m) / (tube.root * ring.root),
               of_n = of_m * (1.0 + torus.ring_per_m * over_m), of_across = of_m * torus.ring_per_m,
               of_t = torus.tube_per_m * along_m / tube.root;
  TorusGap<Number> gap{tube.gap_m, {}};
  for (int r = 0; r < 3; ++r) gap.n[r] = of_n * torus.n[r] + of_across * across_m[r] + of_t * torus.t[r];
  return gap;
}

}  // namespace thenar
