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
#include "engine/grasp/contact_search.h"
#include "engine/grasp/model.h"
#include "engine/hand/muscles.h"

namespace thenar {

class ControlPeriod;

/// What one control tick returns by value: what was asked for, and what it cost.
struct ControlReport {
  ControlReport() = default;
  explicit ControlReport(const Hand& hand)
      : contacts(hand.fingers()),
        gap_m(hand.fingers()),
        f_desired(FingerForces::Zero(3, hand.fingers())),
        torques_desired_Nm(hand.at_zero()) {}

  GraspStatus grasp = GraspStatus::kOptimal;
  MuscleStatus muscle = MuscleStatus::kOptimal;
  MuscleLack muscle_lack;  ///< Of torques that muscles within their limits cannot give: which one is too weak.
  StiffnessReport stiffness;
  double muscle_residual_Nm = 0.0;                     ///< max |H f_m - tau^d|.
  PerFinger<GraspContact> contacts;                    ///< Where the fingers act.
  PerFinger<double> gap_m;                             ///< Without grasp forces: see finger_gap_m(); 0 under load.
  bool has_forces = false;                             ///< f^d, and so the contacts, were asked for: see OwnControl.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< Where the object's origin is, as far as the laws know.
  Vector6d wrench_desired = Vector6d::Zero();          ///< W^d [N, N m], world axes, about it.
  FingerForces f_desired;                              ///< World axes [N]; the last feasible ones if these are not.
  JointVector torques_desired_Nm;                      ///< tau^d, which muscles are to give if there are any.
  ReflexReport reflex;
  TaskReport task;                       ///< Of a task in phases.
  double find_s = 0.0;                   ///< Contact finding.
  double factors_s = 0.0;                ///< Compliance among the contacts.
  double grasp_s = 0.0, muscle_s = 0.0;  ///< Grasp and muscle forces, all included.
  double total_s = 0.0;
};

/// What a caller's functions say instead of the published controller, each alone; an empty one is as published, or
/// as the scene's table has it. Each is
/// called once a control period on the thread of the control tick, if the period asks for what it gives; it may ask for
/// what comes before, and for the published answer (published_wrench(), ...). A vector of another size than is asked
/// for, a number that is not finite, or a muscle that is to push, is std::invalid_argument; what a function throws
/// leaves the control tick.
struct OwnControl {
  /// W^d: wrench on the object beside its weight's, about its origin, world axes [N, N m].
  std::function<Vector6d(ControlPeriod&)> wrench = {};
  /// f^d: a force a finger on the object, world axes, a column a finger [N]. Nothing: there are none, and the last go
  /// on.
  std::function<std::optional<FingerForces>(ControlPeriod&)> forces = {};
  /// tau^d: torques, one a joint [N m]. They bear the hand's own weight, too.
  std::function<JointVector(ControlPeriod&)> torques = {};
  /// f_m: forces, one a muscle [N]; of scenes with muscles. The joints get H f_m.
  std::function<Eigen::VectorXd(ControlPeriod&)> muscles = {};
};

/// The controller's own memory from period to period, and the memory that it works in.
class Controller {
 public:
  explicit Controller(const Model& model);

  std::int64_t sequence = 0;          ///< Of the next frame.
  std::int64_t last_tick = 0;         ///< Of the last snapshot.
  double period_s;                    ///< Simulated time since then; the scene's control period at first.
  double acting_share = 1.0;          ///< Of the pose error: less than 1 in a hold and after it.
  std::optional<PosePid> pid;         ///< Nothing without control.
  int pid_phase = -1;                 ///< Whose gains it has, of a task in phases,
  bool pid_integrates = true;         ///< with integrals,
  Vector6d borne = Vector6d::Zero();  ///< and what the integrals of the phases before it held, about the object.
  std::optional<ForceFilter> filter;  ///< Nothing without control.
  Eigen::VectorXd f_desired;          ///< 3 a finger, world axes [N].
  Eigen::VectorXd f_muscle;           ///< [N].
  Eigen::VectorXd most_N;             ///< Largest forces of the muscles.
  Eigen::MatrixXd H;                  ///< Moment arms [m].
  std::vector<Belly> bellies;         ///< Of a scene whose muscles act on the contact side: see Frame.
  JointVector q_rest;                 ///< Likewise: q_0 of the next frame.
  HandPose pose;
  Afference afference;
  std::optional<Reflex> reflex;               ///< Nothing without touch.
  std::optional<TaskRun> task;                ///< Nothing without phases.
  JointVector q_free;                         ///< Likewise: where the joints of fingers are to be that touch nothing.
  bool looks = false;                         ///< At the grasp, for a stiffness: not at one that does not hold yet.
  std::optional<StiffnessControl> stiffness;  ///< Nothing where no stiffness is chosen.
  ContactSearch search;
  OwnControl own;
};

/// The grasp-force problem of a control tick, about the object's origin. It refers to `report`, with the grips of its
/// reflex.
[[nodiscard]] GraspProblem grasp_problem(const Scene& scene, const ControlReport& report);

}  // namespace thenar
