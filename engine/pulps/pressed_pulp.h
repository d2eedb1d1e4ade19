// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "engine/grasp/pulp.h"

namespace thenar {

/// A pulp pressed on a plane: its control points that may touch, and their forces.
struct PressedPulp {
  std::vector<Eigen::Index> controls;  ///< Indices by increasing gap.
  Eigen::VectorXd force_N;             ///< Forces along the plane's normal.
};

/// Presses a pulp to rest by `depth_m` along `direction` (unit, distal frame) on a rigid plane without friction.
/// Control points whose gap is below `band_m` may touch, and of them the `most` of least gap. To 1e-6 of the natural
/// map.
[[nodiscard]] PressedPulp press(const Pulp& pulp, const Eigen::Vector3d& direction, double depth_m, double band_m,
                                Eigen::Index most);

/// Returns Hertz's force 4/3 E* sqrt(R) d^1.5 on a sphere of this pulp's radius and material, without stiffening. With
/// a direction (unit, distal frame): on the pulp itself pressed on a plane along it, by its two radii of curvature
/// there; for a capsule, to whose side Hertz does not apply, by capsule_load_m2().
[[nodiscard]] double hertz_force_N(const Pulp& pulp, double depth_m);

[[nodiscard]] double hertz_force_N(const Pulp& pulp, const Eigen::Vector3d& direction, double depth_m);

/// Returns the inverse under the load itself: with E* (1 + beta F).
[[nodiscard]] double hertz_depth_m(const Pulp& pulp, double force_N);

[[nodiscard]] double hertz_depth_m(const Pulp& pulp, const Eigen::Vector3d& direction, double force_N);

/// Returns Hertz's contact radius under a load, on a flat object that is rigid or of this material.
[[nodiscard]] double hertz_radius_m(const Pulp& pulp, double force_N, const std::optional<PulpMaterial>& object = {});

/// Returns the factor on hertz_radius_m over the pulp's radius for a pulp that is not a sphere: the product is the
/// lesser semi-axis of its patch over the lesser radius of curvature. 1 for a sphere.
[[nodiscard]] double share_factor(const Pulp& pulp, const Eigen::Vector3d& direction);

}  // namespace thenar
