#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/environment/environment_contacts.h"
#include "engine/grasp/compliance.h"
#include "engine/grasp/delassus.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/joint_stops.h"
#include "engine/grasp/model.h"
#include "engine/grasp/patches.h"
#include "engine/grasp/state.h"
#include "engine/grasp/touch.h"
#include "solvers/grouped_delassus.h"

namespace thenar {

/// What the contact tick does about frames that are noisy, late or lost. The default trusts every frame for ever, as a
/// loop may that makes one for each of its control periods itself.
struct FramePolicy {
  double offset_decay_s = 0.0;  ///< tau_e of the gap offset at a hand-over; 0: no offset.
  double hold_after_s = std::numeric_limits<double>::infinity();  ///< Age of a frame from which its drive is held.
};

/// For frames from another thread: tau_e is a control period, and a frame more than three of them older than
/// expected is too old. Without control the torques are given and do not age.
[[nodiscard]] FramePolicy split_policy(const Scene& scene);

/// What one contact tick works in, and what it keeps from tick to tick beside the state: room for the model's most
/// contacts, taken once. It serves one run: it knows a frame by its sequence number.
struct ContactWorkspace {
  explicit ContactWorkspace(const Model& model, const FramePolicy& policy = {});

  FramePolicy policy;
  std::int64_t sequence = -1;          ///< Of the frame that f and the contacts belong to.
  ContactKinematics kinematics;        ///< Of the frame's contacts, at the start of the tick.
  std::vector<FrameContact> contacts;  ///< That frame's, for the hand-over to the next one.
  Eigen::VectorXd offset_m;            ///< e: what the gaps of contacts are raised by since the hand-over; n.
  Eigen::VectorXd old_offset_m;        ///< The last frame's.
  Eigen::VectorXd delta_free, delta, f, mu;
  Eigen::VectorXd f_first;                ///< What the last solve began with: the forces of the tick before it.
  Mobility mobility{};                    ///< Of the last tick's bodies; none of joints at their stops.
  JointStops stops;                       ///< Of the last tick.
  EnvironmentContacts environment;        ///< Of the last tick, of a scene that has one.
  EnvironmentContacts environment_again;  ///< Scratch.
  GroupedWorkspace solver;
  JointVector torque_Nm;               ///< What drove the fingers in the last tick.
  JointVector resumed_Nm;              ///< What is left of the step in the drive when a hold ended.
  JointVector q_held, torque_held_Nm;  ///< Joints and drive when the hold began.
  PulpLoads loads;
  PatchPoints patches;
  TouchNoise touch_noise;
  HandPose pose;  ///< After a tick, that of the state which it left; q is NaN while there is none.
};

}  // namespace thenar
