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
  kNotThere,      ///< A finger has not come to the object, or does not press it as it is asked to.
  kNotLoaded,     ///< The fingers do not bear the weight: it is held, or too heavy.
  kNotFree,       ///< They bear more or less than the weight where they were to hold the object by themselves.
  kJammed,        ///< More than Phase::most_N resists the arm's way.
  kNothingUnder,  ///< Nothing has borne the object on the arm's way down.
  kNotUnloaded,   ///< The fingers still bear weight though it is left to what is under the object.
  kNotOpen,       ///< A finger still touches the object.
  kArmLate,       ///< The arm has not come to its end.
};

/// What the laws are to do in a control period of a task in phases, and how far the task is.
struct TaskReport {
  int phase = -1;              ///< Of Scene::task.phases; as many as there are: all are done; -1: the task has none.
  double since_s = 0.0;        ///< When it began.
  bool grasps = true;          ///< Grasp forces hold the object; else fingers move by themselves, at
  double speed_m_per_s = 0.0;  ///< this speed along the object's inward normals, but for those that
  PerFinger<bool> has_touched = {};       ///< have touched it since they were to close, and wait, pressing
  double touch_N = 0.0;                   ///< so hard.
  bool holds = true;                      ///< They are to carry it: what slips is lost.
  bool integrates = true;                 ///< With integrals: not against what else bears the object.
  bool poses = true;                      ///< Its pose is controlled, to
  std::optional<Eigen::Isometry3d> X_WT;  ///< here; nothing: to where the scene has it.
  double weight_share = 1.0;              ///< So much of the weight is for the fingers.
  double squeeze_N = 0.0;                 ///< The internal force.
  PhaseFault fault = PhaseFault::kNone;
  int finger = -1;                  ///< Whose fault it is, if it is a finger's.
  double value = 0.0, bound = 0.0;  ///< Force or distance, and what it should have been [N] or [m].
  double way_m = 0.0;               ///< How far the arm had gone in the phase.
};

/// Goes through the phases of a scene's task. A phase ends when what it is for has come about, as far as the control
/// side can know: by the fingers' loads, and by where the arm is.
class TaskRun {
 public:
  /// At the start, or from where a snapshot is.
  explicit TaskRun(const Model& model);

  /// A control period at `seen`, after which the fingers were asked for `asked_N` (3 a finger, world axes).
  void update(const Model& model, const Snapshot& seen, const Eigen::VectorXd& asked_N);

  /// From now on it stays as it is, to be looked at.
  void freeze() { frozen_ = true; }

  [[nodiscard]] const TaskReport& report() const { return report_; }
  [[nodiscard]] const ArmOrder& arm() const { return arm_; }
  /// Whether finger k moves by itself, and does not press.
  [[nodiscard]] bool is_free(int k) const { return !report_.grasps && !report_.has_touched[k]; }
  /// The phase that runs; null before the first and after the last one.
  [[nodiscard]] const Phase* phase(const Scene& scene) const;

 private:
  void begin(const Model& model, const Snapshot& seen, int phase);
  [[nodiscard]] bool step(const Model& model, const Snapshot& seen, const Eigen::VectorXd& asked_N);
  [[nodiscard]] bool close(const Model& model, const Snapshot& seen, const Eigen::VectorXd& asked_N);
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
  double step_since_s_ = 0.0;  ///< When the second half of a phase that has two began,
  bool second_ = false;        ///< which it has.
  double press_N_ = 0.0;       ///< Of the last kClose; before it, as the scene's control asks for.
};

}  // namespace thenar
