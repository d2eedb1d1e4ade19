// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/hand/hand.h"
#include "solvers/grasp_forces.h"
#include "solvers/muscles/muscle_forces.h"
#include "solvers/muscles/stiff_problem.h"

namespace thenar {

/// Forces of the fingers on the object, world axes: a column per finger [N].
using FingerForces = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxFingers>;

/// The desired dynamic wrench D^d: one PID on the position and one on the rotation.
class PosePid {
 public:
  PosePid(const PidGains& position, const PidGains& rotation) : position_(position), rotation_(rotation) {}

  /// Returns the wrench for this error, `period_s` after the last one. Only a `share` of the error acts; at 0 the
  /// integrals are constant.
  Vector6d update(const Vector6d& error, double period_s, double share = 1.0);

  /// Returns the wrench of the integrals alone.
  [[nodiscard]] Vector6d held() const;
  /// Restarts with these gains.
  void restart(const PidGains& position, const PidGains& rotation) { *this = PosePid(position, rotation); }

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(position_, rotation_, integral_, last_error_, started_);
  }

 private:
  PidGains position_, rotation_;
  Vector6d integral_ = Vector6d::Zero();
  Vector6d last_error_ = Vector6d::Zero();
  bool started_ = false;
};

/// Returns the contact of finger k with the object: its pressure centre and the mean normal there; without load the
/// point of its pulp along the object's nearest inward normal. Columns of the frame: n, t1, t2, tangents as in
/// find_frame_contacts.
[[nodiscard]] GraspContact finger_contact(const Model& model, const HandPose& pose, const Snapshot& snapshot,
                                          int finger);

/// Returns the distance of finger k's pulp from the object, negative inside; 0 under load.
[[nodiscard]] double finger_gap_m(const Model& model, const HandPose& pose, const Snapshot& snapshot, int finger);

/// Returns J J' for the inverse in eq. (22): unchanged, except near a singular posture, where J^+ would demand
/// unbounded joint speeds, with damping that increases from zero there [Nakamura & Hanafusa 1986]. Fingers of one or
/// two joints are singular in all postures.
[[nodiscard]] Eigen::Matrix3d damped(Eigen::Matrix3d JJ);

/// The filter of eq. (21), one lag per direction: K_n y_n + nu_n dy_n/dt = e_n, discretised implicitly; tangential
/// alike.
class ForceFilter {
 public:
  explicit ForceFilter(const Model& model);

  /// Returns y [m, world axes] for the force errors of the period, per finger.
  FingerForces update(const PerFinger<GraspContact>& contacts, const FingerForces& error, double period_s);

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(stiffness_, relaxation_s_, y_C_);
  }

 private:
  Eigen::Vector3d stiffness_;       ///< K_n, K_t, K_t [N/m].
  PerFinger<double> relaxation_s_;  ///< nu = relaxation * K; 0 for a rigid fingertip.
  FingerForces y_C_;                ///< Contact axes [m].
};

/// Returns the delay from the state to the effect of its commands: of frames, of feedback, and of muscle relaxation.
[[nodiscard]] double lag_s(const Scene& scene);

/// Returns K of eq. (22): the scene's, or 0.3 times the stability bound 2 b / (control period), and at most 0.6 times
/// the bound 2 b / (control period + delays) of delayed frames and feedback.
[[nodiscard]] double force_gain(const Scene& scene, int finger);

/// Computes the torques that keep a finger's posture in the null space of its fingertip: K Z Z'(q_0 - q), Z the unit
/// directions with J Z = 0, one for each of its `joints` more than three, for an `error` q_0 - q and a `stiffness` K [N
/// m/rad]. They do no work on any motion of the fingertip and carry none of its force, for Z'J' = 0, and do not move
/// it, for all joints have one viscosity. Zero where J is singular, as there are more such directions.
[[nodiscard]] FingerVector posture_torques(const FingerJacobian& J, int joints, double stiffness,
                                           const FingerVector& error);

/// Computes the desired joint torques at joint angles q: eq. (22), K J^+ y; with the feed-forward law plus J' f^d + g;
/// plus posture_torques() for the start posture if the scene has them.
[[nodiscard]] JointVector desired_torques(const Model& model, const JointVector& q, const HandPose& pose,
                                          const Eigen::Vector3d& gravity, const PerFinger<GraspContact>& contacts,
                                          const FingerForces& f_desired, const FingerForces& y);

/// Computes the joint motion of fingers that move with an object with origin at `centre_m` by this motion (of its
/// origin, then its rotation; world axes): J^+ v. Applies to velocities, too.
[[nodiscard]] JointVector joints_with_object(const Hand& hand, const HandPose& pose,
                                             const PerFinger<GraspContact>& contacts, const Eigen::Vector3d& centre_m,
                                             const Vector6d& motion);

/// Computes the viscous joint torques of fingers that move with an object with origin at `centre_m` at this velocity
/// (of its origin, then angular; world axes): b J^+ v.
[[nodiscard]] JointVector viscous_torques(const Model& model, const HandPose& pose,
                                          const PerFinger<GraspContact>& contacts, const Eigen::Vector3d& centre_m,
                                          const Vector6d& velocity);

/// Computes the joint rates of finger k by its contact's velocity, world axes: J^+ v.
[[nodiscard]] FingerVector joints_with_point(const Hand& hand, const HandPose& pose,
                                             const PerFinger<GraspContact>& contacts, int k,
                                             const Eigen::Vector3d& velocity);

/// Predicts the steady force error of eq. (22) without feed-forward, relative to f^d, mean over the fingers:
///     error = (I + S)^-1 S f^d,   S = E diag(K_n, K_t, K_t) E' J J' / K.
[[nodiscard]] double predicted_paper_law_error(const Model& model, const HandPose& pose,
                                               const PerFinger<GraspContact>& contacts, const FingerForces& f_desired);

}  // namespace thenar
