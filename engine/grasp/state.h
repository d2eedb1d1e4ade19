// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <tuple>
#include <vector>

#include "engine/environment/environment_contacts.h"
#include "engine/grasp/model.h"
#include "engine/hand/hand.h"
#include "engine/hand/muscles.h"

namespace thenar {

/// Returns the pose error of an object X against its target T, world axes: position [m], then rotation vector [rad].
[[nodiscard]] Vector6d pose_error(const Eigen::Isometry3d& X_WT, const Eigen::Isometry3d& X_WO);

/// Time constant of the return of the controller's demands after a hold: slow enough to avoid a bump, and fast enough
/// that the object does not go far.
inline constexpr double kResume_s = 0.15;

/// The force at one contact, which the next frame finds again by finger and control point.
struct ContactForce {
  int finger = 0;
  Eigen::Index control_point = 0;
  Eigen::Vector3d f_C = Eigen::Vector3d::Zero();  ///< Force on the object, contact rows (n, t1, t2) [N].
  double held_J = 0.0;                            ///< Its share of the pulp's elastic energy.
  double share = 1.0;                             ///< Share of the control point's cell that it covers.
};

/// Returns the key that orders contacts, their forces and loads, and finds them again from frame to frame.
template <typename Contact>
[[nodiscard]] auto id_of(const Contact& contact) {
  return std::tie(contact.finger, contact.control_point);
}

/// The force by which a soft object is still deformed where a contact acted last, found again as a ContactForce is.
struct ObjectLoad {
  int finger = 0;
  Eigen::Index control_point = 0;
  Eigen::Vector3d x_O;   ///< Point on the surface, object frame.
  double area_m2 = 0.0;  ///< Area of the finger's control point.
  Eigen::Vector3d w_O;   ///< T phi, phi the contact's force filtered with the object's relaxation; object frame [N].
};

/// Capacity per contact, for the loads of former contacts.
inline constexpr Eigen::Index kLoadsPerContact = 4;

/// Tactile signals of a fingertip's patch in a tick. With Coulomb's law in every point its rim slips first: stick falls
/// as (1 - eta)^(2/3), eta = |T| / (mu N), long before the patch slides as a whole [Cattaneo 1938; Mindlin 1949], and
/// where it slips, friction can be sensed.
struct Touch {
  double stick = 1.0;  ///< Share of its loaded area that sticks; 1 without load.
  double friction =
      std::numeric_limits<double>::quiet_NaN();  ///< Sum of |f_t| over that of f_n where it slips; NaN: nowhere.
  double slip_m_per_s = 0.0;                     ///< Slip speed, a mean over the slipping loaded area.
  double moment_Nm = 0.0;  ///< Torsion: about the mean normal, through the pressure centre; signed.
  double normal_N = 0.0;   ///< Load along the mean normal, and below across it: as sensed, with the noise.
  Eigen::Vector3d tangential_N = Eigen::Vector3d::Zero();  ///< World axes.
};

/// Part of the state that the control side sees.
struct Snapshot {
  std::int64_t tick = 0;   ///< Steps taken: the time is tick * step.
  JointVector q;           ///< [rad]
  Eigen::Isometry3d X_WO;  ///< Pose of the object.
  PerFinger<FingerLoad> load;
  /// Forces f of the muscles by activation alone, for a scene whose muscles act on the contact side; else none.
  MuscleVector muscle_N;
  /// Forces with which the muscles pulled in the last tick, for a scene with muscles: f and the effect of the stretch
  /// at its end; without activation and stiffness, the commands of the frame. A muscle with a belly on each of several
  /// fingers pulls with the sum of its bellies. Zero before the first tick.
  MuscleVector pull_N;
  PerFinger<Touch> touch;  ///< Touch, for a scene that names it; else empty.
  /// Sorted contact forces, then entries of no finger, for a scene that chooses its stiffness; else none.
  std::vector<ContactForce> contact_forces;
  ArmWay arm;                             ///< Arm's way, for a scene whose task has phases; else constant.
  std::optional<Eigen::Isometry3d> X_WT;  ///< The caller's target of the object; nothing: the task's.
  bool held = false;                      ///< The drive of an old frame is held: no control acts.
};

/// Snapshot with the data for finding contacts.
struct ContactSnapshot : Snapshot {
  std::vector<Eigen::MatrixX3d> u_m;  ///< Per finger, control points x 3, distal frame: part of the pulp's deformation
                                      ///< in the object's displacement against the finger (the pulp's surface
                                      ///< moves by -u). The memory of friction. Empty for rigid fingertips.
};

/// Returns u at the control point of a contact, distal frame; zero for rigid fingertips.
template <typename Contact>
[[nodiscard]] Eigen::Vector3d displacement(const ContactSnapshot& state, const Contact& contact) {
  if (state.u_m.empty()) return Eigen::Vector3d::Zero();
  return state.u_m[contact.finger].row(contact.control_point).transpose();
}

/// Complete state. Owned and advanced only by contact_tick.
struct State : ContactSnapshot {
  explicit State(const Model& model);

  std::vector<ContactForce> forces;  ///< Sorted by finger and control point; capacity model.max_contacts.
  std::vector<EnvironmentForce> environment_forces;  ///< Forces on the object, in order.
  std::vector<ObjectLoad> object_loads;              ///< Loads in order, kLoadsPerContact times as many; none if rigid.
  PerFinger<double> pulp_energy_J;                   ///< Elastic energy of u, for pulps without stiffening.
  double object_energy_J = 0.0;                      ///< The same of a soft object.
};

/// Returns the state without the data of the run that left it: its caller's target, its hold, and its arm's way.
[[nodiscard]] inline State start_of_run(State state) {
  state.X_WT.reset();
  state.held = false;
  state.arm = {};
  return state;
}

}  // namespace thenar
