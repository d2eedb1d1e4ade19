#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "engine/imports/body_tree.h"
#include "engine/imports/hand_request.h"

namespace thenar {

/// Where a fingertip is: its body, and the frame in it that the request speaks of.
struct TipPlace {
  int body = 0;
  Eigen::Isometry3d X_BP;
  bool is_site = false;
};

/// A joint of a finger.
struct ChainJoint {
  int body = 0;
  int joint = 0;  ///< Among those of the body.
};

/// Which parts of a mechanism are fingers.
struct FingerChains {
  std::vector<TipPlace> tips;
  std::vector<std::vector<ChainJoint>> joints;  ///< Of each finger, from the palm on.
  int base = 0;                                 ///< The body whose frame is the hand's, or that its site is on.
  Eigen::Isometry3d X_BH;                       ///< The hand's frame in it.
  /// One a body: the last body on its way from the root that a finger's joint moves; -1: none, so it is of the palm.
  std::vector<int> moved_with;
  /// One a body, one a joint: how far it is turned or shifted from the pose of the file, where all fingers are at zero.
  std::vector<std::vector<double>> offsets;
  std::vector<int> ties;  ///< The tree's couplings of one of the fingers' joints to another one.
  std::vector<std::string> notes;
};

/// Finds the fingers, and refuses with ConfigError what a hand cannot have: joints of two fingers, joints that do not
/// turn or have no limits, couplings that are no ties, closed loops, more fingers or joints than kMaxFingers and
/// kMaxFingerJoints.
[[nodiscard]] FingerChains find_chains(const BodyTree& tree, const HandRequest& request);

}  // namespace thenar
