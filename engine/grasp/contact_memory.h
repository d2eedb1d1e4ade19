// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/grasp/frame.h"
#include "engine/grasp/joint_stops.h"
#include "engine/grasp/model.h"
#include "engine/grasp/touch.h"
#include "solvers/grouped_delassus.h"

namespace thenar {

/// Policy of the contact tick for noisy, late or lost frames. The default trusts every frame for ever, as suits a loop
/// that makes a frame in each of its control periods itself.
struct FramePolicy {
  double offset_decay_s = 0.0;  ///< tau_e of the gap offset at a hand-over; 0: no offset.
  double hold_after_s = std::numeric_limits<double>::infinity();  ///< Age of a frame from which its drive is held.
};

/// Returns the policy for frames from another thread: tau_e is a control period, and a frame more than three of them
/// older than expected is too old. Without control the torques are given and do not age.
[[nodiscard]] FramePolicy split_policy(const Scene& scene);

/// The memory that a run of contact ticks keeps from tick to tick beside the state. It has room for the model's most
/// contacts, taken once, and serves one run, for it knows a frame by its sequence number. A copy goes on as the
/// original would.
struct ContactMemory {
  explicit ContactMemory(const Model& model, const FramePolicy& policy = {});

  FramePolicy policy;
  std::int64_t sequence = -1;          ///< Number of the frame of f and the contacts.
  std::vector<FrameContact> contacts;  ///< Contacts of that frame, for the hand-over to the next one.
  Eigen::VectorXd offset_m;            ///< e: offset added to the contacts' gaps since the hand-over; n.
  Eigen::VectorXd f;                   ///< Forces of the last tick, contact rows [N].
  Eigen::MatrixX2d change_N;           ///< Its changes by the last tick and by the one before; of new contacts 0.
  JointStops stops;                    ///< Stops of the last tick.
  JointVector torque_Nm;               ///< Drive of the fingers in the last tick.
  JointVector resumed_Nm;              ///< Rest of the step in the drive at the end of a hold.
  JointVector q_held, torque_held_Nm;  ///< Joints and drive when the hold began.
  TouchNoise touch_noise;
  GroupedWorkspace solver;  ///< Keeps the blocks of W from tick to tick, and the object's motion on the ground.
};

/// Takes the room for the model's most contacts that copies have lost; `environment_contacts`: with the environment.
void reserve(const Model& model, std::size_t environment_contacts, State& state, ContactMemory& memory);

}  // namespace thenar
