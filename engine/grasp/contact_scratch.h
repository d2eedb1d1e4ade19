// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/environment/environment_contacts.h"
#include "engine/grasp/compliance.h"
#include "engine/grasp/contact_kinematics.h"
#include "engine/grasp/delassus.h"
#include "engine/grasp/model.h"
#include "engine/grasp/patches.h"
#include "engine/hand/hand.h"
#include "engine/hand/muscles.h"

namespace thenar {

/// Workspace of one contact tick, allocated once for the model's most contacts. It keeps the last tick's results for
/// display; the next tick needs none of them, and may be of another run of the model.
struct ContactScratch {
  explicit ContactScratch(const Model& model);

  ContactKinematics kinematics;   ///< Kinematics of the frame's contacts, at the start of the tick.
  Eigen::VectorXd old_offset_m;   ///< Offsets of the last frame.
  Eigen::MatrixX2d old_change_N;  ///< Likewise.
  Eigen::VectorXd delta_free, delta, mu;
  Eigen::VectorXd f_then;                 ///< Forces of the tick before it, at its own contacts.
  Eigen::VectorXd f_first;                ///< Start of the last solve.
  Mobility mobility{};                    ///< Mobility in the last tick; zero for joints at their stops.
  EnvironmentContacts environment;        ///< Contacts of the last tick, for a scene with an environment.
  EnvironmentContacts environment_again;  ///< Scratch.
  PulpLoads loads;
  PatchPoints patches;
  std::vector<BellyStretch> bellies;  ///< Of the frame's bellies, for a scene whose muscles act on the contact side.
  HandPose pose;                      ///< Pose of the state after the last tick; q is NaN before the first.
};

/// Returns room for the object's contacts with its environment, still to be found; none for a scene without one.
[[nodiscard]] EnvironmentContacts environment_of(const Model& model);

}  // namespace thenar
