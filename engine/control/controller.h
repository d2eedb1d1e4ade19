// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/control/afference.h"
#include "engine/control/control.h"
#include "engine/control/reflex.h"
#include "engine/control/stiff_control.h"
#include "engine/control/task_run.h"
#include "engine/grasp/compliance.h"
#include "engine/grasp/contact_search.h"
#include "engine/grasp/model.h"
#include "engine/hand/muscles.h"

namespace thenar {

class ControlPeriod;

/// Result of one control tick: commands, and computing times.
struct ControlReport {
  ControlReport() = default;
  explicit ControlReport(const Hand& hand)
      : contacts(hand.fingers()),
        gap_m(hand.fingers()),
        f_desired(FingerForces::Zero(3, hand.fingers())),
        torques_desired_Nm(hand.at_zero()) {}

  GraspStatus grasp = GraspStatus::kOptimal;
  MuscleStatus muscle = MuscleStatus::kOptimal;
  MuscleLack muscle_lack;  ///< The muscle that is too weak, for torques that muscles within their limits cannot give.
  StiffnessReport stiffness;
  double muscle_residual_Nm = 0.0;   ///< max |H f_m - tau^d|.
  PerFinger<GraspContact> contacts;  ///< Contacts of the fingers.
  PerFinger<double> gap_m;           ///< Gaps without grasp forces: see finger_gap_m(); 0 under load.
  bool has_forces = false;           ///< True if f^d, and so the contacts, were requested: see OwnControl.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< Position of the object's origin known to the laws.
  Vector6d wrench_desired = Vector6d::Zero();          ///< W^d [N, N m], world axes, about it.
  FingerForces f_desired;          ///< f^d, world axes [N]; the last feasible ones if these are not.
  JointVector torques_desired_Nm;  ///< tau^d, produced by the muscles if there are any.
  ReflexReport reflex;
  TaskReport task;                       ///< State of a task in phases.
  double find_s = 0.0;                   ///< Time of contact finding.
  double factors_s = 0.0;                ///< Time of the compliance among the contacts.
  double grasp_s = 0.0, muscle_s = 0.0;  ///< Times of grasp and muscle forces.
  double total_s = 0.0;
};

/// A caller's functions in place of parts of the published controller; an empty one means the published law or the
/// scene's table. Each is called once a control period on the thread of the control tick, if its result is requested;
/// it may request earlier results and the published one (published_wrench(), ...). A vector of wrong size, a number
/// that is not finite, or a muscle that pushes throws std::invalid_argument; a function's exceptions leave the tick.
struct OwnControl {
  /// W^d: wrench on the object beside its weight's, about its origin, world axes [N, N m].
  std::function<Vector6d(ControlPeriod&)> wrench = {};
  /// f^d: forces on the object, world axes, a column per finger [N]. Nothing: there are none, and the last are kept.
  std::function<std::optional<FingerForces>(ControlPeriod&)> forces = {};
  /// tau^d: torques, one per joint [N m], including those against the hand's own weight.
  std::function<JointVector(ControlPeriod&)> torques = {};
  /// f_m: forces, one per muscle [N], in scenes with muscles. The joints get H f_m.
  std::function<Eigen::VectorXd(ControlPeriod&)> muscles = {};
};

/// The controller's state between periods, and its scratch memory.
class Controller {
 public:
  explicit Controller(const Model& model);

  std::int64_t sequence = 0;          ///< Number of the next frame.
  std::int64_t last_tick = 0;         ///< Tick of the last snapshot.
  double period_s;                    ///< Simulated time since then; the scene's control period at first.
  double acting_share = 1.0;          ///< Share of the pose error that acts: below 1 in a hold and after it.
  std::optional<PosePid> pid;         ///< Nothing without control.
  int pid_phase = -1;                 ///< Phase whose gains it has, in a task in phases.
  bool pid_integrates = true;         ///< True if it integrates.
  Vector6d borne = Vector6d::Zero();  ///< Wrench of the integrals of earlier phases, about the object.
  std::optional<ForceFilter> filter;  ///< Nothing without control.
  Eigen::VectorXd f_desired;          ///< f^d, 3 per finger, world axes [N].
  Eigen::VectorXd f_muscle;           ///< [N].
  Eigen::VectorXd most_N;             ///< Largest forces of the muscles.
  Eigen::MatrixXd H;                  ///< Moment arms [m].
  std::vector<Belly> bellies;         ///< Bellies of a scene whose muscles act on the contact side: see Frame.
  JointVector q_rest;                 ///< q_0 of the next frame, likewise.
  HandPose pose;
  Afference afference;
  std::optional<Reflex> reflex;               ///< Nothing without touch.
  std::optional<TaskRun> task;                ///< Nothing without phases.
  JointVector q_free;                         ///< Target of the joints of free fingers, likewise.
  bool looks = false;                         ///< True if the grasp is evaluated for a stiffness: once it holds.
  std::optional<StiffnessControl> stiffness;  ///< Nothing where no stiffness is chosen.
  ContactSearch search;
  KeptCompliance compliance;
  OwnControl own;
};

/// Returns the grasp-force problem of a control tick, about the object's origin; a view of `report` and its grips.
[[nodiscard]] GraspProblem grasp_problem(const Scene& scene, const ControlReport& report);

}  // namespace thenar
