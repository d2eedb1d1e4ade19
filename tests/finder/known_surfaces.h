// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collision/implicit_surface.h"
#include "collision/shapes.h"
#include "engine/finder/finder.h"
#include "tests/support/scenes.h"

namespace thenar::known_surfaces {

inline const Hand& human_hand() {
  static const Hand hand = scene_of("minimal").hand;
  return hand;
}

/// A problem of the kind that a scene asks: a soft hand of friction 0.6.
inline FinderProblem problem_of(const Hand& hand, const ImplicitSurface& object) {
  FinderProblem problem{.hand = hand, .object = object};
  problem.mass_kg = 0.08;
  problem.gravity = {7.0, 5.6, 4.0};
  problem.friction = 0.6;
  problem.cone_friction = 0.42;
  problem.internal_force_N = 2.0;
  problem.material = PulpMaterial{0.24e6, 0.5, 2e-3};
  return problem;
}

inline ImplicitSurface ball(double radius_m) { return ImplicitSurface(sample_sphere(radius_m, 5000)); }
inline ImplicitSurface box(const Eigen::Vector3d& size_m) { return ImplicitSurface(sample_box(size_m, 8000)); }
inline ImplicitSurface rod(double radius_m, double length_m) {
  return ImplicitSurface(sample_cylinder(radius_m, length_m, 6000));
}

}  // namespace thenar::known_surfaces
