// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "engine/control/controller.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// One control period: the inputs and results of its laws. Each result is computed on demand, once.
class ControlPeriod {
 public:
  /// Begins a period at `now_tick` with the known state `seen`, which is older with control.feedback_delay.
  ControlPeriod(const Model& m, const Snapshot& seen, std::int64_t now_tick, Controller& of, ControlReport& result)
      : model(m), snapshot(seen), now(now_tick), controller(of), report(result) {}
  ControlPeriod(const ControlPeriod&) = delete;
  ControlPeriod& operator=(const ControlPeriod&) = delete;

  const Model& model;
  const Snapshot& snapshot;  ///< The known state: joints, object, contact forces.
  const std::int64_t now;    ///< Tick at which the period begins.
  Controller& controller;    ///< Has the hand's pose at the snapshot, and the period's length.
  ControlReport& report;     ///< Receives all results.
  bool published_wrench_given = false, published_torques_given = false;  ///< True once computed in this period.

  /// Returns the time of the snapshot.
  [[nodiscard]] double time_s() const;
  /// Returns the time at which the period begins.
  [[nodiscard]] double now_s() const;
  /// Returns the gravity known to the controller: the present one if it anticipates, else the scene's.
  [[nodiscard]] Eigen::Vector3d known_gravity() const;
  /// Returns the time of a scene's table: the end of the first tick that this period drives, as in signals.csv.
  [[nodiscard]] double table_time_s() const;
  /// Returns the object's target pose at the snapshot.
  [[nodiscard]] Eigen::Isometry3d target() const;
  /// Returns the error of the object's pose: see pose_error().
  [[nodiscard]] Vector6d error() const;

  /// Returns the contacts of the fingers with the object.
  const PerFinger<GraspContact>& contacts();
  /// Returns J_k: the velocity of finger k's point in contacts() by its joints' speeds; world axes.
  [[nodiscard]] FingerJacobian jacobian(int finger);
  /// Returns H of tau = H f_m, joints x muscles [m].
  const Eigen::MatrixXd& moment_arms();
  const Vector6d& wrench();
  const FingerForces& forces();
  const JointVector& torques();
  [[nodiscard]] bool has_torques() const { return has_torques_; }
  /// Returns the muscle forces f_m; requires a scene with muscles.
  const Eigen::VectorXd& muscle_forces();

 private:
  bool has_contacts_ = false, has_arms_ = false, has_wrench_ = false, has_forces_ = false;
  bool has_torques_ = false, has_muscles_ = false;
  bool finding_wrench_ = false, finding_forces_ = false, finding_torques_ = false, finding_muscles_ = false;
};

// The published laws. Their memory between periods is in the Controller, so each is called at most once a period. All
// but the last require a scene with `control`. Otherwise std::logic_error.
/// Computes the wrench by the PID on the object's pose, plus its weight.
[[nodiscard]] Vector6d published_wrench(ControlPeriod& period);
/// Computes forces within the friction cones for the period's wrench(); nothing if there are none.
[[nodiscard]] std::optional<FingerForces> published_forces(ControlPeriod& period);
/// Computes the torques by force control on the period's forces().
[[nodiscard]] JointVector published_torques(ControlPeriod& period);
/// Computes the least muscle forces for the period's torques(). Throws std::logic_error without muscles.
const Eigen::VectorXd& published_muscle_forces(ControlPeriod& period);

}  // namespace thenar
