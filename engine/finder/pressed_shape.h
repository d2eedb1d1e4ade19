#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "collision/implicit_surface.h"
#include "engine/grasp/pulp.h"
#include "engine/hand/hand.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// How deep a load presses a pulp of the scene's material, or its own, in, by Hertz, on a plane that faces it; and the
/// radius of its patch. An ellipsoid is taken as the sphere of round_radius_m(): where one radius of curvature is three
/// times the other, that is 3 % too deep. Of a capsule it is capsule_depth_m().
[[nodiscard]] double pressed_depth_m(const std::optional<PulpMaterial>& material, const Fingertip& tip, double force_N);
[[nodiscard]] double pressed_radius_m(const std::optional<PulpMaterial>& material, const Fingertip& tip,
                                      double force_N);

/// The load that presses a pulp in as far as it can be trusted.
[[nodiscard]] double greatest_load_N(const std::optional<PulpMaterial>& material, const Fingertip& tip);

/// What a pressed pulp is to the object: its pressure centre, and the mean of the surface's normals under it by load,
/// which on curved surfaces is not the normal at the nearest point. It takes the pressure of a sphere on a plane
/// [Hertz 1882] over what of the pulp is in the object, drawn back by half the depth.
[[nodiscard]] GraspContact pressed_contact(const ImplicitSurface& object, const Eigen::Isometry3d& X_WO,
                                           const Eigen::Vector3d& pulp_W, double radius_m);

/// That of a pulp of any shape.
[[nodiscard]] GraspContact pressed_contact(const ImplicitSurface& object, const Eigen::Isometry3d& X_WO,
                                           const Fingertip& tip, const Eigen::Isometry3d& X_WF);

}  // namespace thenar
