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

/// One force a finger on the object, world axes: a column a finger [N].
using FingerForces = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxFingers>;

/// The desired dynamic wrench D^d: one PID on the position and one on the rotation.
class PosePid {
 public:
  PosePid(const PidGains& position, const PidGains& rotation) : position_(position), rotation_(rotation) {}

  /// The wrench for this error, `period_s` after the last one. Only a share of the error acts; without any the
  /// integrals wait.
  Vector6d update(const Vector6d& error, double period_s, double share = 1.0);

  /// What the integrals hold by themselves.
  [[nodiscard]] Vector6d held() const;
  /// Begins again, with these gains.
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

/// Where finger k acts on the object: its pressure centre and the mean normal there; without load the point of its pulp
/// along the object's nearest inward normal. Columns of the frame: n, t1, t2, tangents as in
/// find_frame_contacts.
[[nodiscard]] GraspContact finger_contact(const Model& model, const HandPose& pose, const Snapshot& snapshot,
                                          int finger);

/// How far the pulp of finger k is from the object, less than 0 inside; 0 under load.
[[nodiscard]] double finger_gap_m(const Model& model, const HandPose& pose, const Snapshot& snapshot, int finger);

/// J J' as eq. (22) inverts it: as it is, but near a singular posture, where J^+ would ask for joint speeds without
/// bounds, with damping that begins there from nothing [Nakamura & Hanafusa 1986]. Fingers of one or two joints are
/// singular in all postures.
[[nodiscard]] Eigen::Matrix3d damped(Eigen::Matrix3d JJ);

/// The filter of eq. (21), one lag a direction: K_n y_n + nu_n dy_n/dt = e_n, discretised implicitly; likewise
/// tangential.
class ForceFilter {
 public:
  explicit ForceFilter(const Model& model);

  /// y [m, world axes] for the force errors of the period, per finger.
  FingerForces update(const PerFinger<GraspContact>& contacts, const FingerForces& error, double period_s);

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(stiffness_, relaxation_s_, y_C_);
  }

 private:
  Eigen::Vector3d stiffness_;       ///< K_n, K_t, K_t [N/m].
  PerFinger<double> relaxation_s_;  ///< nu = relaxation * K; 0 of a rigid fingertip.
  FingerForces y_C_;                ///< Contact axes [m].
};

/// How late what is asked for acts, on what is known late: delays of frames and of knowledge, and muscles that relax.
[[nodiscard]] double lag_s(const Scene& scene);

/// K of eq. (22): the scene's, or 0.3 times the stability bound 2 b / (control period), and not more than 0.6 times the
/// bound 2 b / (control period + delays) of late frames and late knowledge.
[[nodiscard]] double force_gain(const Scene& scene, int finger);

/// What keeps a finger's posture where its fingertip leaves its `joints` free: K Z Z'(q_0 - q), Z the unit directions
/// with J Z = 0, one for each joint more than three, for an `error` q_0 - q and a `stiffness` K [N m/rad]. It does no
/// work on any motion of the fingertip and carries none of its force, for Z'J' = 0, and moves it not, for all joints
/// have one viscosity. Zero where J is singular: then there are more such directions.
[[nodiscard]] FingerVector posture_torques(const FingerJacobian& J, int joints, double stiffness,
                                           const FingerVector& error);

/// The desired joint torques at joint angles q: eq. (22), K J^+ y; with the feed-forward law J' f^d + g besides; and
/// what keeps the start posture, if the scene wants that.
[[nodiscard]] JointVector desired_torques(const Model& model, const JointVector& q, const HandPose& pose,
                                          const Eigen::Vector3d& gravity, const PerFinger<GraspContact>& contacts,
                                          const FingerForces& f_desired, const FingerForces& y);

/// How the joints move where the fingers go with an object whose origin is at `centre_m` and that moves by this motion
/// (of its origin, then its rotation; world axes): J^+ v. Of velocities likewise.
[[nodiscard]] JointVector joints_with_object(const Hand& hand, const HandPose& pose,
                                             const PerFinger<GraspContact>& contacts, const Eigen::Vector3d& centre_m,
                                             const Vector6d& motion);

/// What the joints' viscosity takes where the fingers move with an object whose origin is at `centre_m` and that moves
/// with this velocity (of its origin, then angular; world axes): b J^+ v.
[[nodiscard]] JointVector viscous_torques(const Model& model, const HandPose& pose,
                                          const PerFinger<GraspContact>& contacts, const Eigen::Vector3d& centre_m,
                                          const Vector6d& velocity);

/// How the joints of finger k move where its contact has this velocity, world axes: J^+ v.
[[nodiscard]] FingerVector joints_with_point(const Hand& hand, const HandPose& pose,
                                             const PerFinger<GraspContact>& contacts, int k,
                                             const Eigen::Vector3d& velocity);

/// The steady force error that eq. (22) leaves without feed-forward, as a share of f^d, mean over the fingers:
///     error = (I + S)^-1 S f^d,   S = E diag(K_n, K_t, K_t) E' J J' / K.
[[nodiscard]] double predicted_paper_law_error(const Model& model, const HandPose& pose,
                                               const PerFinger<GraspContact>& contacts, const FingerForces& f_desired);

}  // namespace thenar
