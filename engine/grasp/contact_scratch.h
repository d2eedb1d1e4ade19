#pragma once

#include <Eigen/Core>

#include "engine/environment/environment_contacts.h"
#include "engine/grasp/compliance.h"
#include "engine/grasp/contact_kinematics.h"
#include "engine/grasp/delassus.h"
#include "engine/grasp/model.h"
#include "engine/grasp/patches.h"
#include "engine/hand/hand.h"

namespace thenar {

/// What one contact tick works in: room for the model's most contacts, taken once. It has what the last tick found, for
/// whoever shows it; the next tick needs none of it, and may be of another run of the model.
struct ContactScratch {
  explicit ContactScratch(const Model& model);

  ContactKinematics kinematics;  ///< Of the frame's contacts, at the start of the tick.
  Eigen::VectorXd old_offset_m;  ///< The last frame's.
  Eigen::VectorXd delta_free, delta, mu;
  Eigen::VectorXd f_first;                ///< What the last solve began with: the forces of the tick before it.
  Mobility mobility{};                    ///< Of the last tick's bodies; none of joints at their stops.
  EnvironmentContacts environment;        ///< Of the last tick, of a scene that has one.
  EnvironmentContacts environment_again;  ///< Scratch.
  PulpLoads loads;
  PatchPoints patches;
  HandPose pose;  ///< After a tick, that of the state which it left; q is NaN while there is none.
};

/// Room for the object's contacts with its environment, which are still to be found; of a scene that has none, none.
[[nodiscard]] EnvironmentContacts environment_of(const Model& model);

}  // namespace thenar
