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

/// What the contact tick does about frames that are noisy, late or lost. The default trusts every frame for ever, as a
/// loop may that makes one for each of its control periods itself.
struct FramePolicy {
  double offset_decay_s = 0.0;  ///< tau_e of the gap offset at a hand-over; 0: no offset.
  double hold_after_s = std::numeric_limits<double>::infinity();  ///< Age of a frame from which its drive is held.
};

/// For frames from another thread: tau_e is a control period, and a frame more than three of them older than
/// expected is too old. Without control the torques are given and do not age.
[[nodiscard]] FramePolicy split_policy(const Scene& scene);

/// The memory that a run of contact ticks keeps from tick to tick beside the state. It has room for the model's most
/// contacts, taken once, and serves one run, for it knows a frame by its sequence number. A copy goes on as the
/// original would.
struct ContactMemory {
  explicit ContactMemory(const Model& model, const FramePolicy& policy = {});

  FramePolicy policy;
  std::int64_t sequence = -1;          ///< Of the frame that f and the contacts belong to.
  std::vector<FrameContact> contacts;  ///< That frame's, for the hand-over to the next one.
  Eigen::VectorXd offset_m;            ///< e: what the gaps of contacts are raised by since the hand-over; n.
  Eigen::VectorXd f;                   ///< Of the last tick, contact rows: the next one's first guess [N].
  JointStops stops;                    ///< Of the last tick.
  JointVector torque_Nm;               ///< What drove the fingers in the last tick.
  JointVector resumed_Nm;              ///< What is left of the step in the drive when a hold ended.
  JointVector q_held, torque_held_Nm;  ///< Joints and drive when the hold began.
  TouchNoise touch_noise;
  GroupedWorkspace solver;  ///< It keeps the blocks of W from tick to tick, and where the ground left the object.
};

/// Takes the room for the model's most contacts that copies have lost; `environment_contacts`: with the environment.
void reserve(const Model& model, std::size_t environment_contacts, State& state, ContactMemory& memory);

}  // namespace thenar
