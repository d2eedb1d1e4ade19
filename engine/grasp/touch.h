// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>
#include <span>

#include "engine/grasp/contact_kinematics.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/patches.h"
#include "engine/grasp/state.h"

namespace thenar {

/// Noise of tactile signals: standard normal numbers, the same for the same seed.
struct TouchNoise {
  double share = 0.0;
  std::minstd_rand random;
  std::normal_distribution<double> normal;

  /// Returns 1 plus noise.
  double factor() { return 1.0 + share * normal(random); }
};

/// Computes the tactile signals of finger k from its patch's points after their motion. A point slips where its force
/// is on its friction cone's surface (kOnCone); points with less than a thousandth of the largest normal force are not
/// felt. With noise each contact's normal and tangential force is felt with a factor of its own; which points slip is
/// not noisy.
[[nodiscard]] Touch felt_touch(const Model& model, const Frame& frame, const ContactKinematics& kinematics,
                               std::span<const PatchPoint> patch, const FingerLoad& load, const PatchReport& report,
                               double mu, TouchNoise& noise);

}  // namespace thenar
