#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "engine/grasp/pulp.h"

namespace thenar {

/// What holds a pulp off a plane: its control points that may touch, and their forces.
struct PressedPulp {
  std::vector<Eigen::Index> controls;  ///< By increasing gap.
  Eigen::VectorXd force_N;             ///< Along the plane's normal.
};

/// A pulp at rest, pressed by `depth_m` along `direction` (unit, distal frame) on a rigid plane without friction.
/// Control points whose gap is below `band_m` may touch, and of them the `most` of least gap. To 1e-6 of the natural
/// map.
[[nodiscard]] PressedPulp press(const Pulp& pulp, const Eigen::Vector3d& direction, double depth_m, double band_m,
                                Eigen::Index most);

/// Hertz: 4/3 E* sqrt(R) d^1.5, a sphere of this pulp's radius and material, without stiffening. Below, with a
/// direction (unit, distal frame): the pulp itself pressed on a plane that way, by its two radii of curvature there; of
/// a capsule, which is no body of Hertz's on its side, capsule_load_m2().
[[nodiscard]] double hertz_force_N(const Pulp& pulp, double depth_m);

[[nodiscard]] double hertz_force_N(const Pulp& pulp, const Eigen::Vector3d& direction, double depth_m);

/// Its inverse, under the load itself: with E* (1 + beta F).
[[nodiscard]] double hertz_depth_m(const Pulp& pulp, double force_N);

[[nodiscard]] double hertz_depth_m(const Pulp& pulp, const Eigen::Vector3d& direction, double force_N);

/// Hertz's contact radius under a load, on a flat object: rigid, or as soft as this.
[[nodiscard]] double hertz_radius_m(const Pulp& pulp, double force_N, const std::optional<PulpMaterial>& object = {});

/// What hertz_radius_m over the pulp's radius is to be multiplied by for a pulp that is no sphere: the product is the
/// lesser semi-axis of its patch over the lesser radius of curvature. 1 of a sphere.
[[nodiscard]] double share_factor(const Pulp& pulp, const Eigen::Vector3d& direction);

}  // namespace thenar
