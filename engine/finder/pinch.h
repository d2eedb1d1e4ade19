// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/finder/hand_body.h"
#include "engine/hand/hand.h"

namespace thenar {

/// Pulp and surface normals need not be parallel: a pulp touches with its sides, too.
inline constexpr double kFacing_rad = 0.96;  // 55 degrees

/// A posture in which one finger faces all others across a gap.
struct Pinch {
  double width_m = 0.0;  ///< Width that fits between the undeformed pulps.
  JointVector q;
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();      ///< Unit, from the opposer to the others.
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();  ///< Middle of the gap.
  double cost = 0.0;
};

/// The range of pinches of one finger against the others.
struct PinchRange {
  int opposer = -1;                  ///< -1: no finger can face the others.
  std::vector<Pinch> postures = {};  ///< Postures by width, several for each.
  double least_m = 0.0, most_m = 0.0;
  double best_facing_rad = 0.0;  ///< Without postures: facing error of the best one.
};

/// Searches the hand's postures from random starts. Requires two fingers or more.
[[nodiscard]] PinchRange find_pinches(const Hand& hand, std::uint32_t seed, int effort);

/// Returns the approach direction of the hand: from the palm's middle to the pinch.
[[nodiscard]] Eigen::Vector3d approach_of(const Hand& hand, const Pinch& pinch);

}  // namespace thenar
