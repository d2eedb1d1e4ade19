// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "collision/implicit_surface.h"
#include "engine/grasp/pulp.h"
#include "engine/hand/hand.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// Return the indentation of a pulp of the scene's material, or its own, by a load on a plane that faces it, by Hertz,
/// and the radius of its patch. An ellipsoid counts as the sphere of round_radius_m(), 3 % too deep where one radius of
/// curvature is three times the other. For a capsule it is capsule_depth_m().
[[nodiscard]] double pressed_depth_m(const std::optional<PulpMaterial>& material, const Fingertip& tip, double force_N);
[[nodiscard]] double pressed_radius_m(const std::optional<PulpMaterial>& material, const Fingertip& tip,
                                      double force_N);

/// Returns the load at the largest indentation for which the pulp's law is valid.
[[nodiscard]] double greatest_load_N(const std::optional<PulpMaterial>& material, const Fingertip& tip);

/// Returns the contact of a pressed pulp with the object: its pressure centre, and the load-weighted mean of the
/// surface's normals under it, which on curved surfaces is not the normal at the nearest point. It assumes the pressure
/// of a sphere on a plane [Hertz 1882] over the part of the pulp in the object, moved back by half the depth.
[[nodiscard]] GraspContact pressed_contact(const ImplicitSurface& object, const Eigen::Isometry3d& X_WO,
                                           const Eigen::Vector3d& pulp_W, double radius_m);

/// Returns the contact of a pressed pulp of any shape.
[[nodiscard]] GraspContact pressed_contact(const ImplicitSurface& object, const Eigen::Isometry3d& X_WO,
                                           const Fingertip& tip, const Eigen::Isometry3d& X_WF);

}  // namespace thenar
