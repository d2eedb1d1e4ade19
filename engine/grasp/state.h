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

/// Pose error of an object X against its target T, world axes: position [m], then rotation vector [rad].
[[nodiscard]] Vector6d pose_error(const Eigen::Isometry3d& X_WT, const Eigen::Isometry3d& X_WO);

/// When a hold ends, the controller's demands come back with this time constant: so slowly that it is no bump, and
/// sooner than the object can go far.
inline constexpr double kResume_s = 0.15;

/// The force at one contact, which the next frame finds again by finger and control point.
struct ContactForce {
  int finger = 0;
  Eigen::Index control_point = 0;
  Eigen::Vector3d f_C = Eigen::Vector3d::Zero();  ///< On the object, contact rows (n, t1, t2) [N].
  double held_J = 0.0;                            ///< Its share of the pulp's elastic energy.
  double share = 1.0;                             ///< Of the control point's cell, what the contact stands for.
};

/// By which contacts, their forces and loads are ordered, and found again from frame to frame.
template <typename Contact>
[[nodiscard]] auto id_of(const Contact& contact) {
  return std::tie(contact.finger, contact.control_point);
}

/// The force by which a soft object is still deformed where a contact acted last, found again as a ContactForce is.
struct ObjectLoad {
  int finger = 0;
  Eigen::Index control_point = 0;
  Eigen::Vector3d x_O;   ///< On the surface, object frame.
  double area_m2 = 0.0;  ///< Of the finger's control point.
  Eigen::Vector3d w_O;   ///< T phi, phi the contact's force filtered with the object's relaxation; object frame [N].
};

/// Room for the loads of contacts that are no more.
inline constexpr Eigen::Index kLoadsPerContact = 4;

/// What a fingertip feels of its patch in a tick. With Coulomb's law in every point its rim slips first: stick falls as
/// (1 - eta)^(2/3), eta = |T| / (mu N), long before the patch slides as a whole [Cattaneo 1938; Mindlin 1949], and
/// where it slips, friction can be felt.
struct Touch {
  double stick = 1.0;  ///< Share of its loaded area that sticks; 1 without load.
  double friction =
      std::numeric_limits<double>::quiet_NaN();  ///< Sum of |f_t| over that of f_n where it slips; NaN: nowhere.
  double slip_m_per_s = 0.0;                     ///< How fast what slips does, as a mean over its loaded area.
  double moment_Nm = 0.0;  ///< Torsion: about the mean normal, through the pressure centre; signed.
  double normal_N = 0.0;   ///< Load along the mean normal, and across it: as felt, with the noise.
  Eigen::Vector3d tangential_N = Eigen::Vector3d::Zero();  ///< World axes.
};

/// What the control side sees of the state.
struct Snapshot {
  std::int64_t tick = 0;   ///< Steps taken: the time is tick * step.
  JointVector q;           ///< [rad]
  Eigen::Isometry3d X_WO;  ///< Object.
  PerFinger<FingerLoad> load;
  MuscleVector muscle_N;   ///< Forces that muscles have, of a scene whose muscles act on the contact side.
  PerFinger<Touch> touch;  ///< Of a scene that names it; else of no finger.
  /// Of a scene that chooses its stiffness: the contacts' forces, sorted, and behind them entries of no finger; else
  /// none.
  std::vector<ContactForce> contact_forces;
  ArmWay arm;                             ///< Of a scene whose task has phases; else it stays.
  std::optional<Eigen::Isometry3d> X_WT;  ///< Where the caller wants the object; nothing: where the task does.
  bool held = false;                      ///< The drive of an old frame is held: no control acts.
};

/// And what contacts are found by.
struct ContactSnapshot : Snapshot {
  std::vector<Eigen::MatrixX3d> u_m;  ///< Per finger, control points x 3, distal frame: what the pulp's deformation
                                      ///< adds to the object's displacement against the finger (the pulp's surface
                                      ///< moves by -u). The memory of friction. Empty for rigid fingertips.
};

/// u at the control point of a contact, distal frame; zero for rigid fingertips.
template <typename Contact>
[[nodiscard]] Eigen::Vector3d displacement(const ContactSnapshot& state, const Contact& contact) {
  if (state.u_m.empty()) return Eigen::Vector3d::Zero();
  return state.u_m[contact.finger].row(contact.control_point).transpose();
}

/// All that moves. Owned and advanced by contact_tick alone.
struct State : ContactSnapshot {
  explicit State(const Model& model);

  std::vector<ContactForce> forces;  ///< Sorted by finger and control point; capacity model.max_contacts.
  std::vector<EnvironmentForce> environment_forces;  ///< On the object, in order.
  std::vector<ObjectLoad> object_loads;  ///< Likewise, kLoadsPerContact times as many; of a rigid object none.
  PerFinger<double> pulp_energy_J;       ///< That by which u is held, of pulps without stiffening.
  double object_energy_J = 0.0;          ///< Likewise, of a soft object.
};

/// The state without what belonged to the run that left it: its caller's target, its hold, and its arm's way.
[[nodiscard]] inline State start_of_run(State state) {
  state.X_WT.reset();
  state.held = false;
  state.arm = {};
  return state;
}

}  // namespace thenar
