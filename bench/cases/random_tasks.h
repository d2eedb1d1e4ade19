// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "engine/grasp/model.h"
#include "engine/results/recording.h"

namespace thenar {

/// A random variation of a scene with a task in phases: grip_lift, pick_and_place or peg_assembly. Varied are the
/// object's shape (box, cylinder, ball, superquadric, ellipsoid) and mass, friction, squeeze, press, speeds, damping,
/// tilt of the hand against the world, the peg's offset from its hole, and the contact step.
struct RandomTask {
  std::string name;       ///< The scene.
  std::string variation;  ///< What was drawn, in words.
  Scene scene;
  Eigen::Vector3d goal_m = Eigen::Vector3d::Zero();  ///< Displacement of the object against the environment that the
                                                     ///< phases are to bring about, object axes at the start: of a
                                                     ///< peg from there, else from where it is taken.
  /// True if statics without the engine allow it: the hand's friction bears the weight within what a pulp is good for,
  /// the body stays where it is put, and the hole's chamfer takes the offset.
  bool is_possible = false;
};

/// Returns the variation that belongs to a seed. `delay_s`: frames are so late.
[[nodiscard]] RandomTask random_task(std::uint32_t seed, double delay_s = 0.0);

/// An independent look at the end of a run: by poses and forces of the last second alone, and geometry.
struct TaskLook {
  bool is_in_place = false;  ///< Within 3 mm of where the phases should have brought it from where it was taken (it may
                             ///< roll before); the peg within 0.5 mm of the hole's floor.
  bool is_upright = false;   ///< Within 5 degrees of its attitude when it was taken, but for turns not seen.
  bool is_at_rest = false;   ///< It moved by less than 0.2 mm in the last 0.2 s.
  bool is_free = false;      ///< No finger touches it.
  double off_m = 0.0;        ///< Distance from its place.

  [[nodiscard]] bool is_done() const { return is_in_place && is_upright && is_at_rest && is_free; }
};
[[nodiscard]] TaskLook look_at_end(const RandomTask& task, const Recording& recording);

/// Runs the task, in lockstep where frames are late.
[[nodiscard]] Recording run_task(const RandomTask& task);

}  // namespace thenar
