// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/grasp/pulp.h"
#include "engine/grasp/scene.h"

namespace thenar {

/// Accuracy and cost of a scene's fingertips at one level of detail, see set_level.
struct LevelEstimate {
  int level = 0;
  Eigen::Index controls = 0;  ///< Control points per fingertip.
  double contacts = 0.0;     ///< Per finger at the expected load: mean over directions; at most contact.max_per_finger.
  Eigen::Index needed = 0;   ///< Contacts that carry force then with room for all: largest of a finger.
  double missing = 0.0;      ///< Share of the force that is lost then for want of room: largest of a finger.
  double force_error = 0.0;  ///< Relative to Hertz's force, rms over depths and directions; of a capsule to that of its
                             ///< leaves.
};

/// Makes the scene's fingertips with their leaves as control points.
[[nodiscard]] std::vector<Pulp> make_pulps(const Scene& scene);
/// Tests whether two scenes have the same pulps at the same level. False does not prove that they differ.
[[nodiscard]] bool have_same_pulps(const Scene& one, const Scene& other);

/// Returns the normal load [N] of the most loaded finger: that by the weight on one that alone faces the others, or the
/// controller's internal force if larger; without either, Hertz's force at an eighth of the radius.
[[nodiscard]] double expected_load_N(const Scene& scene, const Pulp& pulp);

/// Estimates pulps at this level, pressed on a plane in a few directions about their middle, up to the expected depth.
[[nodiscard]] LevelEstimate estimate_level(const Scene& scene, const std::vector<Pulp>& pulps, int level);

/// Estimates all levels from the leaves to a handful of control points. Takes the pulps as made by make_pulps, and
/// leaves them at the last level.
[[nodiscard]] std::vector<LevelEstimate> estimate_levels(const Scene& scene, std::vector<Pulp>& pulps);

/// Returns the coarsest level within the error; if there is none, that of the least error.
[[nodiscard]] const LevelEstimate& choose_level(const std::vector<LevelEstimate>& levels, double force_error);

}  // namespace thenar
