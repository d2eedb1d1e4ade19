// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "engine/control/control.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// What a phase lacks to its end; engine/results/task_results.h has its text.
enum class PhaseFault {
  kNone,          ///< Nothing: it is done.
  kTouchesEarly,  ///< A finger touched the object before the fingers were to close.
  kNotThere,      ///< A finger has not come to the object.
  kNotPressing,   ///< A finger's force is not as commanded.
  kNotLoaded,     ///< The fingers do not bear the weight: the object is held, or too heavy.
  kNotFree,       ///< They bear something other than the weight where they should hold the object alone.
  kBehind,        ///< The object has not followed the arm.
  kJammed,        ///< More than Phase::most_N resists the arm's motion.
  kNothingUnder,  ///< Nothing has borne enough of the object while the arm moved down.
  kGaveWay,       ///< What bore it has given way, and the arm has no way left.
  kNotUnloaded,   ///< The fingers still bear weight that the support should bear.
  kNotOpen,       ///< A finger still touches the object.
  kArmLate,       ///< The arm has not reached its target.
};

/// What a phase lacks, by how much.
struct PhaseLack {
  PhaseFault fault = PhaseFault::kNone;
  double value = 0.0;  ///< Force or distance [N] or [m].
  double bound = 0.0;  ///< Bound of `value`.
  int finger = -1;     ///< Finger at fault, if any.
};

/// The commands for a control period of a task in phases, and the task's progress.
struct TaskReport {
  int phase = -1;        ///< Index into Scene::task.phases; their number: all are done; -1: the task has none.
  double since_s = 0.0;  ///< Time at which it began.

  bool holds = true;       ///< True if the fingers carry the object: if it slips it is lost.
  bool grasps = true;      ///< True if grasp forces act. Else each finger moves alone, or touches and waits.
  bool poses = true;       ///< True if the object's pose is controlled.
  bool integrates = true;  ///< True with integrals: not while other bodies support the object.

  double speed_m_per_s = 0.0;        ///< Speed of fingers that move alone, along the object's inward normals.
  PerFinger<bool> has_touched = {};  ///< Fingers that wait for the others.
  double touch_N = 0.0;              ///< Force of these.

  std::optional<Eigen::Isometry3d> X_WT;  ///< Target of the object; nothing: the scene's.
  double weight_share = 1.0;              ///< Share of the weight borne by the fingers.
  double squeeze_N = 0.0;                 ///< The internal force.

  PhaseLack lack;             ///< Of the running phase.
  bool has_failed = false;    ///< True if the phase has failed for what it lacks: the task ends.
  double at_s = 0.0;          ///< Time of the report.
  double arm_way_m = 0.0;     ///< Displacement of the arm in the running phase,
  double object_way_m = 0.0;  ///< and that of the object along it, both against the environment.
};

/// The execution of a scene's task in phases. A phase ends when its aim is reached as far as the control side can tell:
/// by the fingers' loads, the object's pose and the arm's position. It does not know what the environment does.
class TaskRun {
 public:
  explicit TaskRun(const Model& model);

  /// Runs a control period at `seen`, with the hand's pose there; the last commanded `asked_N` (3 per finger, world
  /// axes).
  void update(const Model& model, const HandPose& pose, const Snapshot& seen, const Eigen::VectorXd& asked_N);

  /// Stops all further changes, for inspection.
  void freeze() { frozen_ = true; }

  [[nodiscard]] const TaskReport& report() const { return report_; }
  [[nodiscard]] const ArmOrder& arm() const { return arm_; }
  /// Tests whether finger k moves alone, and does not press.
  [[nodiscard]] bool is_free(int k) const { return !report_.grasps && !report_.has_touched[k]; }
  /// Returns the current phase; null before the first and after the last one.
  [[nodiscard]] const Phase* phase(const Scene& scene) const;

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(report_, arm_, frozen_, now_s_, second_, step_since_s_, met_since_s_, met_arm_m_, met_object_m_, share_from_,
      arm_from_m_, object_from_m_, press_N_);
  }

 private:
  void begin(const Model& model, const Snapshot& seen, int phase);
  /// What the phase lacks now; fatal: it will not come any more.
  struct Step {
    PhaseLack lack = {};
    bool is_fatal = false;
  };
  [[nodiscard]] Step step(const Model& model, const HandPose& pose, const Snapshot& seen,
                          const Eigen::VectorXd& asked_N);
  [[nodiscard]] Step close(const Model& model, const HandPose& pose, const Snapshot& seen,
                           const Eigen::VectorXd& asked_N);
  /// The next two: `against_N` is the force of hand and weight against the environment, world axes.
  [[nodiscard]] Step carry(const Model& model, const Snapshot& seen, const Eigen::Vector3d& against_N);
  [[nodiscard]] Step insert(const Model& model, const Snapshot& seen, const Eigen::Vector3d& against_N);
  [[nodiscard]] Step place(const Model& model, const Snapshot& seen, double load_N);
  [[nodiscard]] Step hand_over(const Model& model, const Snapshot& seen, double load_N);
  [[nodiscard]] Step release(const Phase& phase, const Snapshot& seen);
  void send_arm(const Eigen::Vector3d& by_m, double over_s);
  void stop_arm();
  /// Notes where arm and object are in kPlace as something begins to bear the object.
  void meet(const Scene& scene, const Snapshot& seen);
  [[nodiscard]] bool arm_is_there(const Snapshot& seen) const;
  /// Tests whether it is, and has been for longer than this.
  [[nodiscard]] bool arm_rests(const Snapshot& seen, double for_s) const;
  [[nodiscard]] PhaseLack arm_lacks(const Snapshot& seen, const Phase& phase) const;
  /// Returns the way from the object to its target, world axes.
  [[nodiscard]] Eigen::Vector3d behind_m(const Scene& scene, const Snapshot& seen) const;

  TaskReport report_;
  ArmOrder arm_;
  bool frozen_ = false;
  double now_s_ = 0.0;
  bool second_ = false;        ///< True in the second half of a phase that has two.
  double step_since_s_ = 0.0;  ///< Time at which it began.
  double met_since_s_ = 0.0;   ///< Time since which something bears the object, or holds it back,
  double met_arm_m_ = 0.0;     ///< and how far down arm
  double met_object_m_ = 0.0;  ///< and object were then, in kPlace.
  double share_from_ = 1.0;    ///< The fingers' share of the weight when kPlace began, or began again.
  Eigen::Vector3d arm_from_m_ = Eigen::Vector3d::Zero();     ///< Position of the arm when the phase began,
  Eigen::Vector3d object_from_m_ = Eigen::Vector3d::Zero();  ///< and of the object against the environment.
  double press_N_ = 0.0;  ///< Grip force of the last kClose; before it, that of the scene's control.
};

}  // namespace thenar
