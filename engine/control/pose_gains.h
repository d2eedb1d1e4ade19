// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "engine/grasp/scene.h"

namespace thenar {

/// Gains of the loop that brings the object's pose to its target, and the point that those of the position act on.
struct PoseGains {
  PidGains position, rotation;
  std::optional<Eigen::Vector3d> centre_m;  ///< Object frame; nothing: its origin.

  [[nodiscard]] PoseGains times(double of_position, double of_rotation) const;
};

/// Returns the gains of the scene's control in a phase of its task, by number; of none: those of `control`. A place
/// that follows an insert keeps its gains: the object is still between the same walls. Requires control.
[[nodiscard]] PoseGains pose_gains(const Scene& scene, int phase = -1);

}  // namespace thenar
