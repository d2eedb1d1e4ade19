// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/control/grasp_stiffness.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "solvers/muscles/stiff_muscles.h"

namespace thenar {

/// Result of a control period's choice of stiffness.
struct StiffnessReport {
  bool is_chosen = false;  ///< True if all fingers bear load, the condition of a choice.
  /// Achieved share of the demanded stiffness; below 1 while there are no forces for all of it; 0: least forces.
  double share = 0.0;
  bool is_infeasible = false;  ///< True if a larger share was tried and infeasible.
  // Then: the object's motion with a lack of stiffness, the lack of the full demand, [N/m] along an axis or [N m/rad]
  // about one, and the muscles at their limits, one bit each. Without an axis a finger's posture is unstable.
  std::optional<Eigen::Vector3d> axis_O = {};
  bool rotates = false;
  double lacking = 0.0;
  std::uint64_t at_limit = 0;
  /// Stiffness of the object in the hand about the scene's point, in the object's axes [N/m, N m/rad].
  Matrix6d K_O = Matrix6d::Zero();
  double squeeze_N = 0.0;  ///< Internal force above control.grasp.internal_force.
  int iterations = 0;
  double residual = 0.0;
  bool is_unanswered = false;  ///< True if a larger share that was tried had neither an optimum nor a proof.
};

/// Returns the problem of a scene's muscles with stiffness: the data that no grasp changes, and room for the rest.
[[nodiscard]] StiffMuscleData stiff_problem(const Scene& scene);

/// Sets a grasp and the arms of the muscles there; the caller sets torques and the demand. Does not allocate.
void set_grasp(const Hand& hand, std::span<const Belly> bellies, const GraspStiffness& grasp, StiffMuscleData& problem);

/// Reports the lack of an infeasible problem: the motion in the object's axes, the amount, and the muscles. The part of
/// the demand that was not tried is lacking as a whole.
void tell_lack(const StiffLack& lack, StiffCause cause, double length_m, const Matrix6d& not_tried,
               const Eigen::Isometry3d& X_WO, StiffnessReport& report);

/// The choice of muscle forces for the object stiffness that a scene demands: the least with H f = tau and K_o >= share
/// K_des. If there are none, the share decreases, and after a while slowly increases again. The demand may change
/// between periods, but not whether it may raise the internal force. Memory is allocated once.
class StiffnessControl {
 public:
  explicit StiffnessControl(const Model& model);

  /// Evaluates the grasp of a frame and its snapshot; `pose` is the snapshot's.
  void look(const Model& model, const Frame& frame, const HandPose& pose, const Snapshot& snapshot);

  /// Finds forces f [N] for torques tau of bellies at the snapshot. Each newton of internal force adds the forces
  /// `more_N` on the object. Returns false, f unchanged, if there are none or the fingers bear no load yet.
  bool choose(const Model& model, std::span<const Belly> bellies, const JointVector& tau, const HandPose& pose,
              const PerFinger<GraspContact>& contacts, const FingerForces& more_N, double period_s,
              Eigen::Ref<Eigen::VectorXd> f, StiffnessReport& report);

  /// Returns the problem that was solved last: after a choice that of its forces, else the last that had none.
  [[nodiscard]] const StiffMuscleData& problem() const { return problem_; }
  /// Returns K_des, the demand as a whole.
  [[nodiscard]] const Matrix6d& wanted() const { return wanted_; }
  /// Returns the rise of the internal force in this period.
  [[nodiscard]] double squeeze_N() const { return squeeze_N_; }

  /// For an archive (engine/loops/archive.h), without members that each look recomputes.
  template <typename Archive>
  void members(Archive& a) {
    a(is_loaded_, wanted_, load_N_, last_, centre_m_, share_, waits_s_, squeeze_N_, X_WO_);
  }

 private:
  void find_forces(double period_s, Eigen::Ref<Eigen::VectorXd> f, StiffnessReport& report);
  [[nodiscard]] Matrix6d in_object(const Matrix6d& K_W) const;
  void set_squeeze(const Model& model, const HandPose& pose, const PerFinger<GraspContact>& contacts,
                   const FingerForces& more_N, double period_s);

  StiffnessWorkspace work_;
  std::vector<ContactPlace> places_;
  GraspStiffness grasp_;
  bool is_loaded_ = false;
  Matrix6d wanted_ = Matrix6d::Zero();
  StiffMuscleData problem_;
  PerFinger<double> load_N_;  ///< Normal loads.
  StiffWarmStart last_;
  Eigen::Vector3d centre_m_ = Eigen::Vector3d::Zero();  ///< The scene's point, from the origin; world axes.
  double share_ = 1.0, waits_s_ = 0.0;                  ///< Share that is tried, and time until it increases.
  double squeeze_N_ = 0.0;
  Eigen::Isometry3d X_WO_ = Eigen::Isometry3d::Identity();
};

}  // namespace thenar
