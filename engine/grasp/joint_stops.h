// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "engine/grasp/contact_kinematics.h"
#include "engine/grasp/delassus.h"
#include "engine/grasp/frame.h"
#include "engine/hand/hand.h"

namespace thenar {

/// The stops at the ends of the joints' ranges. With r_j the torque of joint j's stop, q+ = q + dq, tau the drive of
/// the joints in the step h, and b_j their viscosity, the end of a tick satisfies
///     b_j dq_j / h = tau_j + (J_c' f)_j + r_j,
///     0 <= r_j  at the lower end,   r_j (q+_j - lower_j) = 0,    lower_j <= q+_j,
///     0 >= r_j  at the upper end,   r_j (q+_j - upper_j) = 0,    q+_j <= upper_j,
/// together with the laws of contact. A joint at its stop does not give way: its column of J_c in W is zero, and its
/// free motion is the rest of the way to the stop. These joints are an active set. It begins with those of the tick
/// before; after each contact solve, joints that would pass an end are stopped, those that a stop would have to pull
/// are released, each once a tick, and the contact problem is solved again. A tick that changes nothing solves once.
struct JointStops {
  std::array<signed char, kMaxHandJoints> side{};  ///< 1: at the upper end, -1: at the lower one, 0: free.
  std::array<bool, kMaxHandJoints> released{};     ///< Released in this tick.
  int stopped = 0;                                 ///< Number of stopped joints.
};

/// Takes the mobility of the joints that are stopped, in a step of this length.
void stop_joints(const Hand& hand, const JointStops& stops, double step_s, Mobility& mobility);

/// Sets the motion of stopped joints to the rest of the way to their stops; with stiffness the others follow.
/// `mobility` is as stop_joints() leaves it.
void move_to_stops(const Hand& hand, const JointStops& stops, const JointVector& q, double step_s,
                   const Mobility& mobility, const JointVector& torque_Nm, JointVector& dq);

/// Returns r of the joints that are stopped, for the forces f of the contact rows, and zero for the others [N m].
/// `mobility` is that of the joints without their stops.
[[nodiscard]] JointVector stop_torques(const Hand& hand, const JointStops& stops, const Frame& frame,
                                       const ContactKinematics& kinematics, double step_s, const Mobility& mobility,
                                       const JointVector& torque_Nm, const JointVector& dq, const Eigen::VectorXd& f);

/// Stops and releases joints by the motion dq and the torques of the stops that it takes. False: nothing has changed.
[[nodiscard]] bool change_stops(const Hand& hand, const JointVector& q, const JointVector& dq,
                                const JointVector& stop_Nm, JointStops& stops);

/// Ends at their stops the joints that would pass them.
void end_at_stops(const Hand& hand, const JointVector& q, JointVector& dq);

}  // namespace thenar
