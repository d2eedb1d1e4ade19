#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "engine/control/control.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// The reason why a phase has failed; engine/results/task_results.h has its text.
enum class PhaseFault {
  kNone,
  kTouchesEarly,  ///< A finger touched the object before the fingers were to close.
  kNotThere,      ///< A finger has not come to the object.
  kNotPressing,   ///< A finger's force is not as commanded.
  kNotLoaded,     ///< The fingers do not bear the weight: the object is held, or too heavy.
  kNotFree,       ///< They bear more or less than the weight where they should hold the object alone.
  kJammed,        ///< More than Phase::most_N resists the arm's motion.
  kNothingUnder,  ///< Nothing has borne enough of the object while the arm moved down.
  kNotUnloaded,   ///< The fingers still bear weight that the support should bear.
  kNotOpen,       ///< A finger still touches the object.
  kArmLate,       ///< The arm has not reached its target.
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

  PhaseFault fault = PhaseFault::kNone;
  int finger = -1;        ///< Finger at fault, if any.
  double value = 0.0;     ///< Force or distance [N] or [m].
  double bound = 0.0;     ///< Bound of `value`.
  double way_m = 0.0;     ///< Displacement of the arm in the phase that failed.
  double failed_s = 0.0;  ///< Time of the failure.
};

/// The execution of a scene's task in phases. A phase ends when its aim is reached as far as the control side can tell:
/// by the fingers' loads and the arm's position.
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
    a(report_, arm_, frozen_, now_s_, second_, step_since_s_, met_since_s_, arm_from_m_, press_N_);
  }

 private:
  void begin(const Model& model, const Snapshot& seen, int phase);
  [[nodiscard]] bool step(const Model& model, const HandPose& pose, const Snapshot& seen,
                          const Eigen::VectorXd& asked_N);
  [[nodiscard]] bool close(const Model& model, const HandPose& pose, const Snapshot& seen,
                           const Eigen::VectorXd& asked_N);
  /// `against_N`: force of hand and weight against the environment, object axes at the start.
  [[nodiscard]] bool insert(const Phase& phase, const Snapshot& seen, const Eigen::Vector3d& against_N);
  [[nodiscard]] bool place(const Model& model, const Snapshot& seen, double load_N);
  [[nodiscard]] bool release(const Phase& phase, const Snapshot& seen);
  void send_arm(const Scene& scene, const Phase& phase);
  void stop_arm();
  [[nodiscard]] bool arm_is_there(const Snapshot& seen) const;
  void fail(PhaseFault fault, double value, double bound, int finger = -1);

  TaskReport report_;
  ArmOrder arm_;
  bool frozen_ = false;
  double now_s_ = 0.0;
  bool second_ = false;        ///< True in the second half of a phase that has two.
  double step_since_s_ = 0.0;  ///< Time at which it began.
  double met_since_s_ = 0.0;   ///< Time since which the support bears a share of the weight, in kPlace.
  Eigen::Vector3d arm_from_m_ = Eigen::Vector3d::Zero();  ///< Position of the arm when the phase began.
  double press_N_ = 0.0;  ///< Grip force of the last kClose; before it, that of the scene's control.
};

}  // namespace thenar
