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

/// What a control period found of the stiffness that a scene chooses.
struct StiffnessReport {
  bool is_chosen = false;  ///< All fingers bear load: before, there is none to choose.
  /// How much of what is asked for was had; less than 1 while there are no forces for all of it, 0: the least forces
  /// were taken.
  double share = 0.0;
  bool is_infeasible = false;  ///< There were none for a larger share that was tried.
  // Then: which motion of the object lacks how much of all that is asked for, [N/m] along an axis or [N m/rad] about
  // one, and the muscles that it takes at their limits, a bit each. Without an axis it is a finger whose posture gives
  // way.
  std::optional<Eigen::Vector3d> axis_O = {};
  bool rotates = false;
  double lacking = 0.0;
  std::uint64_t at_limit = 0;
  /// Of the object in the hand, about the point that the scene names, in the object's axes [N/m, N m/rad].
  Matrix6d K_O = Matrix6d::Zero();
  double squeeze_N = 0.0;  ///< By how much the internal force is above control.grasp.internal_force.
  int iterations = 0;
  double residual = 0.0;
  bool is_unanswered = false;  ///< For a larger share that was tried there was neither an optimum nor a proof.
};

/// The problem of a scene's muscles, which have stiffness: what no grasp changes, and room for the rest.
[[nodiscard]] StiffMuscleData stiff_problem(const Scene& scene);

/// Puts in a grasp, and the arms of the muscles there; torques and what is asked for are the caller's. Does not
/// allocate.
void set_grasp(const Hand& hand, std::span<const Belly> bellies, const GraspStiffness& grasp, StiffMuscleData& problem);

/// Puts what an infeasible problem lacks into a report: the motion in the object's axes, how much, and the muscles.
/// What was not even tried of what is asked for lacks as a whole.
void tell_lack(const StiffLack& lack, StiffCause cause, double length_m, const Matrix6d& not_tried,
               const Eigen::Isometry3d& X_WO, StiffnessReport& report);

/// Chooses muscle forces for the stiffness of the object that a scene asks for: the least with H f = tau and K_o >=
/// share K_des. If there are none, it takes less, and after a while tries slowly for more again. What the scene asks
/// for may change between periods, but not whether it may squeeze for it. Its memory is taken once.
class StiffnessControl {
 public:
  explicit StiffnessControl(const Model& model);

  /// The grasp as a frame and its snapshot have it; `pose` is the snapshot's.
  void look(const Model& model, const Frame& frame, const HandPose& pose, const Snapshot& snapshot);

  /// Forces f [N] for torques tau of bellies at the snapshot. A newton of squeeze adds the forces `more_N` on the
  /// object. False, and f is as it was: there are none, or the fingers bear no load yet.
  bool choose(const Model& model, std::span<const Belly> bellies, const JointVector& tau, const HandPose& pose,
              const PerFinger<GraspContact>& contacts, const FingerForces& more_N, double period_s,
              Eigen::Ref<Eigen::VectorXd> f, StiffnessReport& report);

  /// What the internal force is raised by in this period.
  [[nodiscard]] double squeeze_N() const { return squeeze_N_; }

  /// For an archive (engine/loops/archive.h), without what each look makes anew.
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
  PerFinger<double> load_N_;  ///< Normal ones.
  StiffWarmStart last_;
  Eigen::Vector3d centre_m_ = Eigen::Vector3d::Zero();  ///< That point, from the origin; world axes.
  double share_ = 1.0, waits_s_ = 0.0;                  ///< What is tried, and how long until it is more.
  double squeeze_N_ = 0.0;
  Eigen::Isometry3d X_WO_ = Eigen::Isometry3d::Identity();
};

}  // namespace thenar
