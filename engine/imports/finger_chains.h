// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "engine/imports/body_tree.h"
#include "engine/imports/hand_request.h"

namespace thenar {

/// The place of a fingertip: its body, and the requested frame in it.
struct TipPlace {
  int body = 0;
  Eigen::Isometry3d X_BP;
  bool is_site = false;
};

/// A joint of a finger.
struct ChainJoint {
  int body = 0;
  int joint = 0;  ///< Index among those of the body.
};

/// The parts of a mechanism that are fingers.
struct FingerChains {
  std::vector<TipPlace> tips;
  std::vector<std::vector<ChainJoint>> joints;  ///< Joints of each finger, from the palm on.
  int base = 0;                                 ///< Body of the hand's frame or its site.
  Eigen::Isometry3d X_BH;                       ///< The hand's frame in that body.
  /// One per body: the last body on its path from the root that a finger's joint moves; -1: none, part of the palm.
  std::vector<int> moved_with;
  /// Per body and joint: its rotation or translation from the file's pose at zero of all fingers.
  std::vector<std::vector<double>> offsets;
  std::vector<int> ties;  ///< Indices of the tree's couplings between joints of the fingers.
  std::vector<std::string> notes;
};

/// Finds the fingers. Throws ConfigError for features that a hand cannot have: joints of two fingers, joints that are
/// not hinges or have no limits, couplings other than ties, closed loops, more fingers or joints than kMaxFingers and
/// kMaxFingerJoints.
[[nodiscard]] FingerChains find_chains(const BodyTree& tree, const HandRequest& request);

}  // namespace thenar
