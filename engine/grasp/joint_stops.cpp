// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/joint_stops.h"

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Index;

namespace {

// What a contact solve leaves open of a joint's torque: a stop may pull so much.
constexpr double kOpen_Nm = 1e-9;

/// How far the joint can still turn towards this side. A state that begins beyond an end is not thrown back.
double way_left(const Joint& joint, double q, int side) {
  return side > 0 ? std::max(joint.upper_rad - q, 0.0) : std::min(joint.lower_rad - q, 0.0);
}

/// The side on which the joint would pass its end; 0: on neither. No stop makes a finite motion of one that is not.
int passes(const Joint& joint, double q, double dq) {
  if (dq <= joint.upper_rad - q && dq >= joint.lower_rad - q) return 0;  // Nearly always.
  if (!std::isfinite(dq)) return 0;
  if (dq > way_left(joint, q, 1)) return 1;
  return dq < way_left(joint, q, -1) ? -1 : 0;
}

}  // namespace

void stop_joints(const Hand& hand, const JointStops& stops, double step_s, Mobility& mobility) {
  if (stops.stopped == 0) return;
  for (int k = 0; k < hand.fingers() && mobility.is_stiff(); ++k) {
    const Fingertip& tip = hand.fingertips[k];
    std::array<bool, kMaxFingerJoints> free;
    for (int j = 0; j < tip.joints; ++j) free[j] = stops.side[tip.first_joint + j] == 0;
    mobility.factor[k] = mobility_factor(mobility.damping[k], mobility.joint, step_s, free);
  }
  if (mobility.is_stiff()) return;
  const auto joints = std::ssize(hand.joints);
  if (mobility.root.size() == 0) mobility.root.setOnes(joints);
  for (Index j = 0; j < joints; ++j) {
    if (stops.side[j] != 0) mobility.root[j] = 0.0;
  }
}

void move_to_stops(const Hand& hand, const JointStops& stops, const JointVector& q, double step_s,
                   const Mobility& mobility, const JointVector& torque_Nm, JointVector& dq) {
  if (stops.stopped == 0) return;
  if (mobility.is_stiff()) {
    // B_ff dq_f = h tau_f - B_fs dq_s of the free and the stopped joints of a finger.
    JointVector torque = torque_Nm;
    for (int k = 0; k < hand.fingers(); ++k) {
      const Fingertip& tip = hand.fingertips[k];
      for (int s = 0; s < tip.joints; ++s) {
        const int j = tip.first_joint + s;
        if (stops.side[j] == 0) continue;
        const double way_rad = way_left(hand.joints[j], q[j], stops.side[j]);
        torque.segment(tip.first_joint, tip.joints) -= way_rad / step_s * mobility.damping[k].col(s);
      }
    }
    dq = joint_motion(hand, mobility, torque);
  }
  for (Index j = 0; j < dq.size(); ++j) {
    if (stops.side[j] != 0) dq[j] = way_left(hand.joints[j], q[j], stops.side[j]);
  }
}

JointVector stop_torques(const Hand& hand, const JointStops& stops, const Frame& frame,
                         const ContactKinematics& kinematics, double step_s, const Mobility& mobility,
                         const JointVector& torque_Nm, const JointVector& dq, const Eigen::VectorXd& f) {
  JointVector stop_Nm = hand.at_zero();
  for (int k = 0; k < hand.fingers() && stops.stopped > 0; ++k) {
    const Fingertip& tip = hand.fingertips[k];
    const Index first = 3 * frame.begin[k], rows = 3 * frame.begin[k + 1] - first;
    for (int c = 0; c < tip.joints; ++c) {
      const int j = tip.first_joint + c;
      if (stops.side[j] == 0) continue;
      const auto f_k = f.segment(first, rows);
      const double contact_Nm = c < GroupedDelassus::kOwn ? kinematics.J_finger.col(c).segment(first, rows).dot(f_k)
                                                          : kinematics.J_fifth.segment(first, rows).dot(f_k);
      const double viscous_Nm = mobility.is_stiff()
                                    ? mobility.damping[k].row(c).dot(dq.segment(tip.first_joint, tip.joints)) / step_s
                                    : dq[j] / mobility.of_joint(j);
      stop_Nm[j] = viscous_Nm - torque_Nm[j] - contact_Nm;
    }
  }
  return stop_Nm;
}

bool change_stops(const Hand& hand, const JointVector& q, const JointVector& dq, const JointVector& stop_Nm,
                  JointStops& stops) {
  bool changed = false;
  for (Index j = 0; j < q.size(); ++j) {
    if (stops.side[j] == 0) {
      stops.side[j] = static_cast<signed char>(passes(hand.joints[j], q[j], dq[j]));
      changed = changed || stops.side[j] != 0;
    } else if (stops.side[j] * stop_Nm[j] > kOpen_Nm && !stops.released[j]) {
      stops.side[j] = 0;
      stops.released[j] = changed = true;
    }
  }
  if (changed) {
    stops.stopped = static_cast<int>(std::count_if(stops.side.begin(), stops.side.end(), [](int s) { return s != 0; }));
  }
  return changed;
}

void end_at_stops(const Hand& hand, const JointVector& q, JointVector& dq) {
  for (Index j = 0; j < q.size(); ++j) {
    if (passes(hand.joints[j], q[j], dq[j]) == 0) continue;
    dq[j] = std::clamp(dq[j], way_left(hand.joints[j], q[j], -1), way_left(hand.joints[j], q[j], 1));
  }
}

}  // namespace thenar
