#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <optional>

#include "engine/grasp/contact_search.h"
#include "engine/grasp/control.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

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
  double muscle_residual_Nm = 0.0;             ///< max |H f_m - tau^d|.
  PerFinger<GraspContact> contacts;            ///< Where the fingers act.
  PerFinger<double> gap_m;                     ///< Without grasp forces: see finger_gap_m(); 0 under load.
  bool has_forces = false;                     ///< f^d, and so the contacts, were asked for: see OwnControl.
  Vector6d wrench_desired = Vector6d::Zero();  ///< W^d [N, N m], world axes, about the object's origin.
  FingerForces f_desired;                      ///< World axes [N]; the last feasible ones if these are not.
  JointVector torques_desired_Nm;              ///< tau^d, which muscles are to give if there are any.
  double find_s = 0.0;                         ///< Contact finding.
  double factors_s = 0.0;                      ///< Compliance among the contacts.
  double grasp_s = 0.0, muscle_s = 0.0;        ///< Grasp and muscle forces, all included.
  double total_s = 0.0;
};

/// What a caller's functions say instead of the published controller, each alone; an empty one is as published. Each is
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

  /// Takes those of another that are there.
  void take(const OwnControl& other);
};

/// What the scene's table of torques or muscle forces says instead, if it has one.
[[nodiscard]] OwnControl control_by_table(const Scene& scene);

/// The controller's own memory from period to period, and the memory that it works in.
class Controller {
 public:
  explicit Controller(const Model& model);

  std::int64_t sequence = 0;          ///< Of the next frame.
  std::int64_t last_tick = 0;         ///< Of the last snapshot.
  double period_s;                    ///< Simulated time since then; the scene's control period at first.
  double acting_share = 1.0;          ///< Of the pose error: less than 1 in a hold and after it.
  std::optional<PosePid> pid;         ///< Nothing without control.
  std::optional<ForceFilter> filter;  ///< Nothing without control.
  Eigen::VectorXd f_desired;          ///< 3 a finger, world axes [N].
  Eigen::VectorXd f_muscle;           ///< [N].
  Eigen::MatrixXd H;                  ///< Moment arms [m].
  HandPose pose;
  ContactSearch search;
  OwnControl own;
};

/// The grasp-force problem of a control tick, about the object's origin. It refers to `report`.
[[nodiscard]] GraspProblem grasp_problem(const Scene& scene, const ControlReport& report,
                                         const Eigen::Vector3d& centre_m);

/// One control period: what its laws see, and what they have found. What a period is asked for is found then, once.
class ControlPeriod {
 public:
  ControlPeriod(const Model& m, const Snapshot& seen, Controller& of, ControlReport& result)
      : model(m), snapshot(seen), controller(of), report(result) {}
  ControlPeriod(const ControlPeriod&) = delete;
  ControlPeriod& operator=(const ControlPeriod&) = delete;

  const Model& model;
  const Snapshot& snapshot;  ///< What is known of the state: joints, object, what the fingers do to it.
  Controller& controller;    ///< With the hand's pose at the snapshot, and the period's length.
  ControlReport& report;     ///< Has all that was found.

  [[nodiscard]] double time_s() const;
  /// Where the object should be at that time.
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
};

// The published laws. They keep what they need to know from period to period in the Controller: each at most once a
// period. All but the last are for scenes with `control`: std::logic_error.
/// The PID on the object's pose, and its weight.
[[nodiscard]] Vector6d published_wrench(ControlPeriod& period);
/// Within the friction cones, for the period's wrench(). Nothing if there are none.
[[nodiscard]] std::optional<FingerForces> published_forces(ControlPeriod& period);
/// The force control on the period's forces().
[[nodiscard]] JointVector published_torques(ControlPeriod& period);
/// The least muscle forces for the period's torques(). Of scenes with muscles: std::logic_error.
const Eigen::VectorXd& published_muscle_forces(ControlPeriod& period);

}  // namespace thenar
