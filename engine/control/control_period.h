#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "engine/control/controller.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// One control period: what its laws see, and what they have found. What a period is asked for is found then, once.
class ControlPeriod {
 public:
  /// `seen` is what is known, `now_tick` when the period begins; with control.feedback_delay they are not of one time.
  ControlPeriod(const Model& m, const Snapshot& seen, std::int64_t now_tick, Controller& of, ControlReport& result)
      : model(m), snapshot(seen), now(now_tick), controller(of), report(result) {}
  ControlPeriod(const ControlPeriod&) = delete;
  ControlPeriod& operator=(const ControlPeriod&) = delete;

  const Model& model;
  const Snapshot& snapshot;  ///< What is known of the state: joints, object, what the fingers do to it.
  const std::int64_t now;    ///< Its tick, but for what is known late.
  Controller& controller;    ///< With the hand's pose at the snapshot, and the period's length.
  ControlReport& report;     ///< Has all that was found.
  bool published_wrench_given = false, published_torques_given = false;  ///< These go on from period to period.

  /// Of the snapshot.
  [[nodiscard]] double time_s() const;
  /// When the period begins.
  [[nodiscard]] double now_s() const;
  /// Gravity as it is now, of which a controller that anticipates knows all; others know the scene's.
  [[nodiscard]] Eigen::Vector3d known_gravity() const;
  /// When a scene's table is looked at: at the end of the first tick that this period drives, as signals.csv has it.
  [[nodiscard]] double table_time_s() const;
  /// Where the object should be at the snapshot.
  [[nodiscard]] Eigen::Isometry3d target() const;
  /// Of the object against its target: see pose_error().
  [[nodiscard]] Vector6d error() const;

  /// Where the fingers act on the object.
  const PerFinger<GraspContact>& contacts();
  /// J_k: the velocity of the point of finger k that contacts() has, for its joints' speeds; world axes.
  [[nodiscard]] FingerJacobian jacobian(int finger);
  /// H of tau = H f_m, joints x muscles [m].
  const Eigen::MatrixXd& moment_arms();
  const Vector6d& wrench();
  const FingerForces& forces();
  const JointVector& torques();
  [[nodiscard]] bool has_torques() const { return has_torques_; }
  /// Of a scene with muscles.
  const Eigen::VectorXd& muscle_forces();

 private:
  bool has_contacts_ = false, has_arms_ = false, has_wrench_ = false, has_forces_ = false;
  bool has_torques_ = false, has_muscles_ = false;
  bool finding_wrench_ = false, finding_forces_ = false, finding_torques_ = false, finding_muscles_ = false;
};

// The published laws. They keep what they need to know from period to period in the Controller: each at most once a
// period. All but the last are for scenes with `control`. Otherwise std::logic_error.
/// The PID on the object's pose, and its weight.
[[nodiscard]] Vector6d published_wrench(ControlPeriod& period);
/// Within the friction cones, for the period's wrench(). Nothing if there are none.
[[nodiscard]] std::optional<FingerForces> published_forces(ControlPeriod& period);
/// The force control on the period's forces().
[[nodiscard]] JointVector published_torques(ControlPeriod& period);
/// The least muscle forces for the period's torques(). Of scenes with muscles: std::logic_error.
const Eigen::VectorXd& published_muscle_forces(ControlPeriod& period);

}  // namespace thenar
