// SPDX-License-Identifier: Apache-2.0
#include "engine/control/control_period.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "engine/control/pose_gains.h"
#include "engine/grasp/stopwatch.h"
#include "engine/hand/muscles.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

// Largest ratio of grasp forces to the commanded wrench, moments at this lever.
constexpr double kMostForce = 100.0, kLeastLever_m = 1e-2;

const ControlSettings& settings_of(const Model& model) {
  if (!model.scene.control) throw std::logic_error("a scene without control has no published controller");
  return *model.scene.control;
}

/// Returns the scene's table of muscle forces, or of torques; null if it has none.
const DriveTable* table_of(const Scene& scene, bool muscles) {
  if (!scene.control || !scene.control->drive || scene.control->drive->muscles != muscles) return nullptr;
  return &*scene.control->drive;
}

/// A guard of a result that is being computed, which its own inputs must not request.
class Finding {
 public:
  Finding(bool& finding, const char* what) : finding_(finding) {
    if (finding) throw std::logic_error(std::string("a law asks for ") + what + ", which waits for that law");
    finding_ = true;
  }
  ~Finding() { finding_ = false; }
  Finding(const Finding&) = delete;
  Finding& operator=(const Finding&) = delete;

 private:
  bool& finding_;
};

/// Throws unless this is the first call: the controller's state advances with each answer.
void expect_first(bool& given, const char* what) {
  if (given) throw std::logic_error(std::string(what) + " as published is found once a period");
  given = true;
}

/// Checks the result of a caller's function, here where it can be named.
template <typename Numbers>
const Numbers& checked(const Numbers& numbers, Index asked, const char* what) {
  if (numbers.size() != asked) {
    throw std::invalid_argument(std::string(what) + ": " + std::to_string(numbers.size()) + " numbers, not " +
                                std::to_string(asked));
  }
  if (!numbers.allFinite()) throw std::invalid_argument(std::string(what) + ": a number is not finite");
  return numbers;
}

bool anticipates(const Model& model) { return model.scene.control && model.scene.control->anticipation; }

/// Returns the middle of the time for which this period's drive acts.
double planned_s(const ControlPeriod& period) {
  return period.now_s() + period.model.scene.control_delay_s + 0.5 * period.model.scene.control_period_s;
}

}  // namespace

double ControlPeriod::time_s() const { return static_cast<double>(snapshot.tick) * model.scene.step_s; }

double ControlPeriod::now_s() const { return static_cast<double>(now) * model.scene.step_s; }

Eigen::Vector3d ControlPeriod::known_gravity() const {
  return anticipates(model) ? model.gravity(now_s()) : model.scene.gravity;
}

double ControlPeriod::table_time_s() const { return now_s() + model.scene.step_s; }

Eigen::Isometry3d ControlPeriod::target() const {
  return snapshot.X_WT.value_or(report.task.X_WT ? *report.task.X_WT : model.target(time_s()));
}

Vector6d ControlPeriod::error() const { return pose_error(target(), snapshot.X_WO); }

const PerFinger<GraspContact>& ControlPeriod::contacts() {
  if (!has_contacts_) {
    for (int k = 0; k < model.fingers(); ++k) report.contacts[k] = finger_contact(model, controller.pose, snapshot, k);
    has_contacts_ = true;
  }
  return report.contacts;
}

FingerJacobian ControlPeriod::jacobian(int finger) {
  return finger_jacobian(model.scene.hand, controller.pose, finger, contacts()[finger].point_m);
}

const Eigen::MatrixXd& ControlPeriod::moment_arms() {
  if (!has_arms_) thenar::moment_arms(model.scene.hand, controller.pose, controller.H);
  has_arms_ = true;
  return controller.H;
}

const Vector6d& ControlPeriod::wrench() {
  if (!has_wrench_) {
    const Finding once(finding_wrench_, "wrench");
    const auto& own = controller.own.wrench;
    report.wrench_desired = own ? checked(own(*this), 6, "wrench of the caller's law") : published_wrench(*this);
    has_wrench_ = true;
  }
  return report.wrench_desired;
}

const FingerForces& ControlPeriod::forces() {
  if (has_forces_) return report.f_desired;
  const Finding once(finding_forces_, "forces");
  Stopwatch stage;
  const auto& own = controller.own.forces;
  if (const auto f = own ? own(*this) : published_forces(*this)) {
    controller.f_desired = checked(*f, 3 * model.fingers(), "grasp forces of the caller's law").reshaped();
    report.grasp = GraspStatus::kOptimal;
  } else {
    if (own) report.grasp = GraspStatus::kInfeasible;
    contacts();
    for (int k = 0; k < model.fingers(); ++k) report.gap_m[k] = finger_gap_m(model, controller.pose, snapshot, k);
  }
  report.f_desired = controller.f_desired.reshaped(3, model.fingers());
  report.has_forces = has_forces_ = true;
  contacts();
  report.grasp_s = stage.lap();
  return report.f_desired;
}

const JointVector& ControlPeriod::torques() {
  if (!has_torques_) {
    const Finding once(finding_torques_, "torques");
    const auto& own = controller.own.torques;
    const auto joints = std::ssize(model.scene.hand.joints);
    if (own) {
      report.torques_desired_Nm = checked(own(*this), joints, "joint torques of the caller's law");
    } else if (const DriveTable* table = table_of(model.scene, false)) {
      report.torques_desired_Nm = table->at(table_time_s());
    } else {
      report.torques_desired_Nm = published_torques(*this);
    }
    has_torques_ = true;
  }
  return report.torques_desired_Nm;
}

const Eigen::VectorXd& ControlPeriod::muscle_forces() {
  if (has_muscles_) return controller.f_muscle;
  const Finding once(finding_muscles_, "muscles");
  const MuscleSettings& settings = *model.scene.control->muscles;
  if (settings.frozen_from_s && controller.sequence > 0 && now_s() >= *settings.frozen_from_s) {
    has_muscles_ = true;
    return controller.f_muscle;
  }
  if (const auto& own = controller.own.muscles) {
    const auto muscles = std::ssize(model.scene.hand.muscles);
    const Eigen::VectorXd f = checked(own(*this), muscles, "muscle forces of the caller's law");
    Index pushing = 0;
    if (muscles > 0 && f.minCoeff(&pushing) < 0.0) {
      throw std::invalid_argument("muscle forces of the caller's law: " + model.scene.hand.muscles[pushing].name +
                                  " is to push, and muscles pull");
    }
    controller.f_muscle = f;
  } else if (const DriveTable* table = table_of(model.scene, true)) {
    const Eigen::VectorXd f = table->at(table_time_s());
    controller.f_muscle = f;  // A copy, in place: others look at it where it lies.
  } else {
    published_muscle_forces(*this);
  }
  has_muscles_ = true;
  return controller.f_muscle;
}

namespace {

Vector3d to_centre_m(const ControlPeriod& period, const std::optional<Vector3d>& centre_O) {
  return centre_O ? Vector3d(period.snapshot.X_WO.linear() * *centre_O) : Vector3d::Zero();
}

/// Returns the error that the PID controls.
Vector6d error_about(const ControlPeriod& period, const std::optional<Vector3d>& centre_O) {
  Vector6d error = period.error();
  if (centre_O) error.head<3>() += period.target().linear() * *centre_O - to_centre_m(period, centre_O);
  return error;
}

/// Moves a wrench from the centre to the object's origin.
void move_to_origin(const ControlPeriod& period, const std::optional<Vector3d>& centre_O, Vector6d& wrench) {
  if (centre_O) wrench.tail<3>() += to_centre_m(period, centre_O).cross(Vector3d(wrench.head<3>()));
}

/// Returns the wrench of the proportional gains, about the object's origin.
Vector6d proportional(const ControlPeriod& period, const PoseGains& gains) {
  Vector6d wrench = error_about(period, gains.centre_m);
  wrench.head<3>() *= period.controller.acting_share * gains.position.p;
  wrench.tail<3>() *= period.controller.acting_share * gains.rotation.p;
  move_to_origin(period, gains.centre_m, wrench);
  return wrench;
}

/// Returns the wrench on the object, about its origin, of the forces that were asked for last.
Vector6d last_wrench(ControlPeriod& period) {
  Vector6d wrench = Vector6d::Zero();
  for (int k = 0; k < period.model.fingers(); ++k) {
    const Vector3d f = period.controller.f_desired.segment<3>(3 * k);
    wrench.head<3>() += f;
    wrench.tail<3>() += (period.contacts()[k].point_m - period.snapshot.X_WO.translation()).cross(f);
  }
  return wrench;
}

/// Sets the gains of another phase, without a bump [Astrom & Hagglund 2006, 3.5]: what the fingers were asked for
/// beyond the object's weight and what the new gains make of the error, about a new centre or against a new target, is
/// still needed, for what pushes the object out of its place still does. It is released with the weight to the object's
/// support.
void change_gains(ControlPeriod& period) {
  Controller& controller = period.controller;
  const TaskReport& task = period.report.task;
  if (controller.pid_phase == task.phase && controller.pid_integrates == task.integrates) return;
  const PoseGains before = pose_gains(period.model.scene, controller.pid_phase);
  PoseGains now = pose_gains(period.model.scene, task.phase);
  if (task.poses && controller.pid_phase >= 0 && task.weight_share >= 1.0) {
    const Vector6d weight = period.model.weight(period.snapshot.X_WO, period.known_gravity());
    controller.borne = last_wrench(period) + weight - proportional(period, now);
  } else {
    Vector6d held = controller.pid->held();
    move_to_origin(period, before.centre_m, held);
    controller.borne = task.weight_share > 0.0 ? Vector6d(controller.borne + held) : Vector6d::Zero();
  }
  controller.pid_phase = task.phase;
  controller.pid_integrates = task.integrates;
  if (!task.integrates) now.position.i = now.rotation.i = 0.0;
  controller.pid->restart(now.position, now.rotation);
}

}  // namespace

Vector6d published_wrench(ControlPeriod& period) {
  settings_of(period.model);
  expect_first(period.published_wrench_given, "the wrench");
  Controller& controller = period.controller;
  const TaskReport& task = period.report.task;
  // In a hold no command acts. The error that has accumulated there returns as slowly as the drive does.
  const double fade = std::exp(-controller.period_s / kResume_s);
  controller.acting_share = period.snapshot.held ? 0.0 : 1.0 - fade * (1.0 - controller.acting_share);
  if (controller.task) change_gains(period);
  const std::optional<Vector3d> centre_O = pose_gains(period.model.scene, task.phase).centre_m;
  const Vector6d error = error_about(period, centre_O);
  Vector6d D = Vector6d::Zero();
  if (task.poses) D = controller.pid->update(error, controller.period_s, controller.acting_share);
  move_to_origin(period, centre_O, D);
  Vector6d known = period.model.weight(period.snapshot.X_WO, period.known_gravity());
  if (controller.task) {
    D += task.weight_share * controller.borne;
    known *= task.weight_share;
  }
  if (!anticipates(period.model)) return D - known;
  const ObjectSettings& object = period.model.scene.object;
  Vector6d drag = period.model.target_velocity(planned_s(period));
  drag.head<3>() *= object.translation_damping;
  drag.tail<3>() *= object.rotation_damping;
  return D + controller.acting_share * drag - known;
}

namespace {

/// Returns forces of fingers that move alone: those that touch the object press it slightly.
FingerForces touching_forces(ControlPeriod& period) {
  FingerForces f = FingerForces::Zero(3, period.model.fingers());
  for (int k = 0; k < period.model.fingers(); ++k) {
    if (!period.controller.task->is_free(k)) f.col(k) = period.report.task.touch_N * period.contacts()[k].axes.col(0);
  }
  return f;
}

}  // namespace

std::optional<FingerForces> published_forces(ControlPeriod& period) {
  settings_of(period.model);
  ControlReport& report = period.report;
  if (!report.task.grasps) return touching_forces(period);
  const Vector6d& wrench = period.wrench();
  period.contacts();
  const GraspProblem problem = grasp_problem(period.model.scene, report);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3 * kMaxFingers, 1> f = period.controller.f_desired;
  report.grasp = solve_grasp_forces(problem, f).status;
  // Contacts that hardly resist some moment take forces that no finger has: that is no grasp.
  double squeeze_N = problem.internal_force_N;
  for (const ContactGrip& grip : report.reflex.grips) squeeze_N = std::max(squeeze_N, grip.internal_force_N);
  const double asked_N = squeeze_N + wrench.head<3>().norm() + wrench.tail<3>().norm() / kLeastLever_m;
  if (report.grasp == GraspStatus::kOptimal && f.norm() > kMostForce * asked_N) report.grasp = GraspStatus::kInfeasible;
  if (report.grasp != GraspStatus::kOptimal) return std::nullopt;
  return f.reshaped(3, period.model.fingers());
}

namespace {

/// Makes muscles with stiffness pull the joints to their angles with the object at its target, within the joints'
/// ranges, beyond which bones would bear the load. The force control senses the effect on the object like all others:
/// with feed-forward it would act on expectations from an old snapshot, and oscillate.
void let_muscles_pull(ControlPeriod& period) {
  const Hand& hand = period.model.scene.hand;
  const Snapshot& snapshot = period.snapshot;
  Controller& controller = period.controller;
  controller.q_rest =
      snapshot.q + joints_with_object(hand, controller.pose, period.contacts(), snapshot.X_WO.translation(),
                                      controller.acting_share * period.error());
  for (Index i = 0; i < controller.q_rest.size(); ++i) {
    const double q = snapshot.q[i], lower = std::min(q, hand.joints[i].lower_rad),
                 upper = std::max(q, hand.joints[i].upper_rad);
    controller.q_rest[i] = std::clamp(controller.q_rest[i], lower, upper);
  }
}

}  // namespace

namespace {

/// Moves free fingers along the object's normals, and holds the resulting posture, which compliant muscles would let
/// drift.
void move_free_fingers(ControlPeriod& period, JointVector& tau) {
  constexpr double kMost_per_s = 10.0;  // Rate of return to it.
  const Model& model = period.model;
  Controller& controller = period.controller;
  if (controller.q_free.size() == 0) controller.q_free = period.snapshot.q;
  const double rate_per_s = std::min(kMost_per_s, 0.3 / (model.scene.control_period_s + lag_s(model.scene)));
  for (int k = 0; k < model.fingers(); ++k) {
    const Fingertip& tip = model.scene.hand.fingertips[k];
    auto wanted = controller.q_free.segment(tip.first_joint, tip.joints);
    const auto q = period.snapshot.q.segment(tip.first_joint, tip.joints);
    if (!controller.task->is_free(k)) {
      wanted = q;
      continue;
    }
    const Vector3d velocity = period.report.task.speed_m_per_s * period.contacts()[k].axes.col(0);
    const FingerVector dq = joints_with_point(model.scene.hand, controller.pose, period.contacts(), k, velocity);
    wanted += controller.period_s * dq.head(tip.joints);
    for (int j = 0; j < tip.joints; ++j) {
      const Joint& joint = model.scene.hand.joints[tip.first_joint + j];
      wanted[j] = std::clamp(wanted[j], std::min(q[j], joint.lower_rad), std::max(q[j], joint.upper_rad));
      tau[tip.first_joint + j] += model.scene.viscosity(k) * joint.drag * (dq[j] + rate_per_s * (wanted[j] - q[j]));
    }
  }
}

}  // namespace

JointVector published_torques(ControlPeriod& period) {
  settings_of(period.model);
  const Model& model = period.model;
  const FingerForces& f_desired = period.forces();
  expect_first(period.published_torques_given, "what the joints are asked for");
  FingerForces error(3, model.fingers());
  for (int k = 0; k < model.fingers(); ++k) error.col(k) = f_desired.col(k) - period.snapshot.load[k].force_N;
  if (model.scene.has_muscles() && model.scene.control->muscles->short_range) let_muscles_pull(period);
  Controller& controller = period.controller;
  const PerFinger<GraspContact>& contacts = period.contacts();
  const FingerForces y = controller.filter->update(contacts, error, controller.period_s);
  JointVector tau =
      desired_torques(model, period.snapshot.q, controller.pose, period.known_gravity(), contacts, f_desired, y);
  if (controller.task) move_free_fingers(period, tau);
  if (anticipates(model)) {
    const Vector6d velocity = controller.acting_share * model.target_velocity(planned_s(period));
    tau += viscous_torques(model, controller.pose, contacts, period.snapshot.X_WO.translation(), velocity);
  }
  return tau;
}

namespace {

/// Finds forces within the limits whose torques miss those asked for least, and of these the least: joints are helped
/// by motors, whose arms are so short that muscles do what they can first. False if there are too many muscles.
bool find_nearest_forces(const MuscleProblem& problem, Eigen::VectorXd& f) {
  constexpr double kArm_m = 1e-4;  // At muscles' arms of 5 mm a motor misses 1e-4 of what a muscle would give.
  constexpr double kUnlimited = std::numeric_limits<double>::infinity();
  const Index joints = problem.H.rows(), muscles = problem.H.cols(), all = muscles + 2 * joints;
  if (joints > kMaxJoints || all > kMaxMuscles) return false;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, kMaxMuscles> H(joints, all);
  H.leftCols(muscles) = problem.H;
  H.rightCols(2 * joints).setZero();
  for (Index i = 0; i < joints; ++i) {
    H(i, muscles + i) = kArm_m;
    H(i, muscles + joints + i) = -kArm_m;
  }
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxMuscles, 1> limit(all), forces(all);
  limit.head(muscles) = problem.limit;
  limit.tail(2 * joints).setConstant(kUnlimited);
  if (solve_muscle_forces({H, problem.tau, limit}, forces).status != MuscleStatus::kOptimal) return false;
  f = forces.head(muscles);
  return true;
}

/// Computes the least muscle forces for these torques. If limits do not allow them: those that come nearest.
void find_least_forces(ControlPeriod& period, const JointVector& tau) {
  Controller& controller = period.controller;
  const MuscleProblem problem{period.moment_arms(), tau, controller.most_N};
  const MuscleReport found = solve_muscle_forces(problem, controller.f_muscle);
  period.report.muscle = found.status;
  if (found.status != MuscleStatus::kInfeasible) return;
  period.report.muscle_lack = muscle_lack(problem, found.multiplier);
  if (find_nearest_forces(problem, controller.f_muscle)) return;
  const MuscleProblem without_limits{problem.H, tau};
  if (solve_muscle_forces(without_limits, controller.f_muscle).status != MuscleStatus::kOptimal) return;
  controller.f_muscle = controller.f_muscle.cwiseMin(controller.most_N);
}

/// Returns the forces of this period per newton of internal force.
FingerForces more_squeeze(ControlPeriod& period) {
  const Model& model = period.model;
  ControlReport squeezed = period.report;
  squeezed.stiffness.squeeze_N += 1.0;
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3 * kMaxFingers, 1> f = period.controller.f_desired;
  const GraspProblem problem = grasp_problem(model.scene, squeezed);
  if (solve_grasp_forces(problem, f).status != GraspStatus::kOptimal) return FingerForces::Zero(3, model.fingers());
  return f.reshaped(3, model.fingers()) - period.report.f_desired;
}

bool choose_stiff_forces(ControlPeriod& period, const JointVector& tau) {
  Controller& controller = period.controller;
  const auto& wanted = *period.model.scene.control->muscles->object_stiffness;
  FingerForces more_N = FingerForces::Zero(3, period.model.fingers());
  if (wanted.most_squeeze_N > 0.0) more_N = more_squeeze(period);
  const bool found =
      controller.stiffness->choose(period.model, controller.bellies, tau, controller.pose, period.contacts(), more_N,
                                   controller.period_s, controller.f_muscle, period.report.stiffness);
  if (found) period.report.muscle = MuscleStatus::kOptimal;
  return found;
}

}  // namespace

const Eigen::VectorXd& published_muscle_forces(ControlPeriod& period) {
  if (!period.model.scene.has_muscles()) throw std::logic_error("the scene has no muscles");
  Controller& controller = period.controller;
  const JointVector& tau = period.torques();
  Stopwatch stage;
  const bool chooses = controller.looks && period.report.task.holds;
  if (!chooses || !choose_stiff_forces(period, tau)) find_least_forces(period, tau);
  period.report.muscle_s = stage.lap();
  return controller.f_muscle;
}

}  // namespace thenar
