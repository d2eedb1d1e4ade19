// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "engine/grasp/scene.h"
#include "engine/hand/coupled_joints.h"

namespace thenar {

/// The scene with the last joints of its index and major (of four joints each, as in hand.yaml) turning with those
/// before them, 0.7 times as far, so that they are where the posture has them.
inline Scene with_coupled_ends(Scene scene) {
  constexpr double kRatio = 0.7;
  std::vector<Coupling> couplings;
  JointVector posture = scene.posture;
  Eigen::Index kept = 0;
  for (const Fingertip& tip : scene.hand.fingertips) {
    const int last = tip.first_joint + tip.joints - 1;
    const bool is_coupled = tip.first_joint > 0;
    for (int j = tip.first_joint; j <= last; ++j) {
      if (!is_coupled || j < last) posture[kept++] = scene.posture[j];
    }
    if (!is_coupled) continue;
    couplings.push_back({last, last - 1, kRatio, scene.posture[last] - kRatio * scene.posture[last - 1]});
  }
  scene.hand = coupled(std::move(scene.hand), couplings);
  scene.posture = posture.head(kept).eval();
  return scene;
}

}  // namespace thenar
