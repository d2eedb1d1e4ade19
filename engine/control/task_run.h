#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "engine/control/control.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// Why a phase has failed; engine/results/task_results.h has the words.
enum class PhaseFault {
  kNone,
  kTouchesEarly,  ///< A finger touched the object before the fingers were to close.
  kNotThere,      ///< A finger has not come to the object.
  kNotPressing,   ///< A finger's force is not as it is asked for.
  kNotLoaded,     ///< The fingers do not bear the weight: it is held, or too heavy.
  kNotFree,       ///< They bear more or less than the weight where they were to hold the object by themselves.
  kJammed,        ///< More than Phase::most_N resists the arm's way.
  kNothingUnder,  ///< Nothing has borne enough of the object on the arm's way down.
  kNotUnloaded,   ///< The fingers still bear weight though it is left to what is under the object.
  kNotOpen,       ///< A finger still touches the object.
  kArmLate,       ///< The arm has not come to its end.
};

/// What the laws are to do in a control period of a task in phases, and how far the task is.
struct TaskReport {
  int phase = -1;        ///< Of Scene::task.phases; as many as there are: all are done; -1: the task has none.
  double since_s = 0.0;  ///< When it began.

  bool holds = true;       ///< The fingers are to carry the object: what slips is lost.
  bool grasps = true;      ///< Grasp forces act. Else each finger goes by itself, or touches and waits.
  bool poses = true;       ///< The object's pose is controlled.
  bool integrates = true;  ///< With integrals: not against what else bears the object.

  double speed_m_per_s = 0.0;        ///< Of fingers that go by themselves, along the object's inward normals.
  PerFinger<bool> has_touched = {};  ///< Fingers that wait for the others.
  double touch_N = 0.0;              ///< What these press with.

  std::optional<Eigen::Isometry3d> X_WT;  ///< Where the object is held; nothing: where the scene has it.
  double weight_share = 1.0;              ///< So much of the weight is for the fingers.
  double squeeze_N = 0.0;                 ///< The internal force.

  PhaseFault fault = PhaseFault::kNone;
  int finger = -1;        ///< Whose fault it is, if it is a finger's.
  double value = 0.0;     ///< Force or distance [N] or [m].
  double bound = 0.0;     ///< What it should have been.
  double way_m = 0.0;     ///< How far the arm had gone in the phase that failed.
  double failed_s = 0.0;  ///< When it failed.
};

/// Goes through the phases of a scene's task. A phase ends when what it is for has come about, as far as the control
/// side can know: by the fingers' loads, and by where the arm is.
class TaskRun {
 public:
  explicit TaskRun(const Model& model);

  /// A control period at `seen`, with the hand's pose there; the last one asked the fingers for `asked_N` (3 a finger,
  /// world axes).
  void update(const Model& model, const HandPose& pose, const Snapshot& seen, const Eigen::VectorXd& asked_N);

  /// From now on it stays as it is, to be looked at.
  void freeze() { frozen_ = true; }

  [[nodiscard]] const TaskReport& report() const { return report_; }
  [[nodiscard]] const ArmOrder& arm() const { return arm_; }
  /// Whether finger k moves by itself, and does not press.
  [[nodiscard]] bool is_free(int k) const { return !report_.grasps && !report_.has_touched[k]; }
  /// The phase that runs; null before the first and after the last one.
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
  /// `against_N`: what hand and weight together do against the environment, object axes at the start.
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
  bool second_ = false;        ///< The second half of a phase that has two has begun.
  double step_since_s_ = 0.0;  ///< When that was.
  double met_since_s_ = 0.0;   ///< Since when something else bears a share of the weight, in kPlace.
  Eigen::Vector3d arm_from_m_ = Eigen::Vector3d::Zero();  ///< Where the arm was when the phase began.
  double press_N_ = 0.0;  ///< Of the last kClose; before it, as the scene's control asks for.
};

}  // namespace thenar
