#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/grasp/pulp.h"
#include "engine/grasp/scene.h"

namespace thenar {

/// How well and at what cost a scene's fingertips would do at one level of detail, see set_level.
struct LevelEstimate {
  int level = 0;
  Eigen::Index controls = 0;  ///< A fingertip.
  double contacts = 0.0;      ///< A finger at the expected load: mean over directions; contact.max_per_finger at most.
  Eigen::Index needed = 0;    ///< Contacts that carry force then if the list has room for all: the most of a finger.
  double missing = 0.0;       ///< Share of the force that the pulp lacks then for want of room: the most of a finger.
  double force_error = 0.0;   ///< Of the force against Hertz's, rms over depths and directions; of a capsule's against
                              ///< that of its leaves.
};

/// The scene's fingertips with their leaves as control points.
[[nodiscard]] std::vector<Pulp> make_pulps(const Scene& scene);
/// Whether two scenes have the same pulps at the same level. False does not prove that they differ.
[[nodiscard]] bool have_same_pulps(const Scene& one, const Scene& other);

/// The normal load [N] of the hardest-working finger: what the weight asks of one that alone faces the others, or the
/// controller's internal force, whichever is more; without either, Hertz's force at an eighth of the radius.
[[nodiscard]] double expected_load_N(const Scene& scene, const Pulp& pulp);

/// What pulps do that are at this level: pressed on a plane in a few directions about their middle, up to the depth
/// that the expected load gives.
[[nodiscard]] LevelEstimate estimate_level(const Scene& scene, const std::vector<Pulp>& pulps, int level);

/// All levels from the leaves to a handful of control points. Takes the pulps as make_pulps makes them, and leaves them
/// at the last level.
[[nodiscard]] std::vector<LevelEstimate> estimate_levels(const Scene& scene, std::vector<Pulp>& pulps);

/// The coarsest level within the error; where there is none, that of the least error.
[[nodiscard]] const LevelEstimate& choose_level(const std::vector<LevelEstimate>& levels, double force_error);

}  // namespace thenar
