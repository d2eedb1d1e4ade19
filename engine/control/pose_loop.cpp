// SPDX-License-Identifier: Apache-2.0
#include "engine/control/pose_loop.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <utility>

#include "engine/control/afference.h"
#include "engine/grasp/state.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Returns the compliance of a pulp on the object at a load, to its contact's displacement [m/N] and rotation [rad/N/m]
/// without slip: with a the radius of Hertz's contact, 1 / (2 E* a) along the normal [Johnson 1985, eq. 4.23] and c_t
/// times that across it [Mindlin 1949; ibid., eq. 7.43]. A rolling pulp takes its pressure with it, by R per rad: F R =
/// 4/3 E* a^3. About the normal it twists with 8/3 (1 - nu) E* a^3 [Reissner and Sagoci 1944; ibid., eq. 3.109].
Matrix6d pulp_compliance(const Model& model, int k, const Matrix3d& axes, double normal_N) {
  constexpr double kHard_m_per_N = 1e-8, kFree_rad_per_Nm = 1e6;
  Vector6d along;
  along << Vector3d::Constant(kHard_m_per_N), Vector3d::Constant(kFree_rad_per_Nm);
  if (model.deformable()) {
    const Pulp& pulp = model.pulps[k];
    double per_Pa = softness(pulp.material, normal_N) / pulp.material.reduced_modulus_Pa;
    if (model.soft_object()) per_Pa += 1.0 / model.scene.object.compliance->reduced_modulus_Pa;
    const double radius_m = std::cbrt(0.75 * normal_N * pulp.radius_m * per_Pa);
    const double straight = per_Pa / (2.0 * radius_m), rolls = 1.0 / (normal_N * pulp.radius_m);
    along << straight, pulp.tangential * straight, pulp.tangential * straight,
        rolls / (2.0 * (1.0 - pulp.material.poisson)), rolls, rolls;
  }
  Matrix6d to_world = Matrix6d::Zero();
  to_world.topLeftCorner<3, 3>() = to_world.bottomRightCorner<3, 3>() = axes;
  return to_world * along.asDiagonal() * to_world.transpose();
}

/// The grasp forces at the start, and their derivatives by the wrench and by the contacts' points.
struct ForceDerivatives {
  VectorXd f;
  MatrixXd by_wrench, by_points;
};

/// Returns those of the problem that the controller solves, by central differences; where that has no answer, those of
/// the least forces without cones.
ForceDerivatives force_derivatives(const Model& model, const ControlReport& start, double lever_m) {
  constexpr double kSome = 1e-3, kSome_m = 1e-6;
  const Index rows = 3 * model.fingers();
  const GraspProblem problem = grasp_problem(model.scene, start);
  ForceDerivatives all{VectorXd::Zero(rows), MatrixXd::Zero(rows, 6), MatrixXd::Zero(rows, rows)};
  bool found = solve_grasp_forces(problem, all.f).status == GraspStatus::kOptimal;
  std::array<VectorXd, 2> beside;
  for (int axis = 0; axis < 6 && found; ++axis) {
    const double some = kSome * std::max(all.f.norm(), problem.internal_force_N) * (axis < 3 ? 1.0 : lever_m);
    for (int side = 0; side < 2 && found; ++side) {
      GraspProblem off = problem;
      off.wrench[axis] += side == 0 ? -some : some;
      beside[side] = all.f;
      found = solve_grasp_forces(off, beside[side]).status == GraspStatus::kOptimal;
    }
    all.by_wrench.col(axis) = (beside[1] - beside[0]) / (2.0 * some);
  }
  for (Index row = 0; row < rows && found; ++row) {
    for (int side = 0; side < 2 && found; ++side) {
      std::vector<GraspContact> contacts(start.contacts.begin(), start.contacts.end());
      contacts[row / 3].point_m[row % 3] += side == 0 ? -kSome_m : kSome_m;
      GraspProblem off = problem;
      off.contacts = contacts;
      beside[side] = all.f;
      found = solve_grasp_forces(off, beside[side]).status == GraspStatus::kOptimal;
    }
    all.by_points.col(row) = (beside[1] - beside[0]) / (2.0 * kSome_m);
  }
  if (found) return all;
  MatrixXd G(6, rows);
  grasp_map(problem.contacts, problem.centre_m, G);
  all.by_wrench = G.completeOrthogonalDecomposition().pseudoInverse();
  for (int k = 0; k < model.fingers(); ++k) {
    all.f.segment<3>(3 * k) = problem.internal_force_N * start.contacts[k].axes.col(0);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d moment = Vector3d::Unit(axis).cross(Vector3d(all.f.segment<3>(3 * k)));
      all.by_points.col(3 * k + axis) = -all.by_wrench.rightCols<3>() * moment;
    }
  }
  return all;
}

/// Returns the motion of a point of the object, `lever_m` from its origin, for the object's.
Eigen::Matrix<double, 3, 6> motion_at(const Vector3d& lever_m) {
  Eigen::Matrix<double, 3, 6> at;
  at.leftCols<3>().setIdentity();
  for (int axis = 0; axis < 3; ++axis) at.col(3 + axis) = Vector3d::Unit(axis).cross(lever_m);
  return at;
}

int steps_of_period(const Scene& scene) {
  return std::max(1, static_cast<int>(std::lround(scene.control_period_s / scene.step_s)));
}

/// Returns the axis of a motion that may turn its way as it swings: the longer one of its ellipse, along which it is
/// where its phase makes its square real.
Vector3d axis_of(const Eigen::Vector3cd& swing) {
  const std::complex<double> square = (swing.transpose() * swing).value();
  const Vector3d axis = (swing * std::polar(1.0, -0.5 * std::arg(square))).real().normalized();
  Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  return axis[largest] < 0.0 ? Vector3d(-axis) : axis;
}

/// Returns the grasp at the start of a scene, held against the weight.
ControlReport first_grasp(const Model& model, const HandPose& pose, const State& start) {
  ControlReport report(model.scene.hand);
  report.centre_m = start.X_WO.translation();
  report.wrench_desired = -model.weight(start.X_WO);
  for (int k = 0; k < model.fingers(); ++k) {
    GraspContact& contact = report.contacts[k];
    contact = finger_contact(model, pose, start, k);
    contact.point_m += finger_gap_m(model, pose, start, k) * contact.axes.col(0);  // Onto the object.
  }
  return report;
}

}  // namespace

PoseLoop::PoseLoop(const Model& model, const ControlReport* solved) : model_(model) {
  const Scene& scene = model.scene;
  const State start(model);
  X_WO_ = start.X_WO;
  HandPose pose;
  forward_kinematics(scene.hand, start.q, pose);
  const ControlReport report = solved != nullptr ? *solved : first_grasp(model, pose, start);
  for (const GraspContact& contact : report.contacts) {
    centroid_m_ += (contact.point_m - report.centre_m) / model.fingers();
  }
  T_ = MatrixXd::Zero(6 * model.fingers(), 6);
  for (int k = 0; k < model.fingers(); ++k) {
    const Vector3d at_m = report.contacts[k].point_m - report.centre_m;
    T_.middleRows<3>(6 * k) = motion_at(at_m);
    T_.block<3, 3>(6 * k + 3, 3).setIdentity();
    lever_m_ += (at_m - centroid_m_).squaredNorm() / model.fingers();
  }
  lever_m_ = std::sqrt(lever_m_);
  ForceDerivatives forces = force_derivatives(model, report, lever_m_);
  by_wrench_ = std::move(forces.by_wrench);
  by_points_ = std::move(forces.by_points);
  for (int k = 0; k < model.fingers(); ++k) add_finger(pose, k, report.contacts[k], forces.f.segment<3>(3 * k));
}

void PoseLoop::add_finger(const HandPose& pose, int k, const GraspContact& contact, const Vector3d& f) {
  const Scene& scene = model_.scene;
  const Fingertip& tip = scene.hand.fingertips[k];
  const FingerJacobian J = finger_jacobian(scene.hand, pose, k, contact.point_m);
  Finger finger;
  finger.first = tip.first_joint;
  finger.J.resize(6, tip.joints);
  finger.J << J.leftCols(tip.joints), turning_axes(scene.hand, pose, k).leftCols(tip.joints);
  finger.mobility.resize(tip.joints);
  finger.posture = MatrixXd::Zero(tip.joints, tip.joints);
  for (int j = 0; j < tip.joints; ++j) {
    const double drag = scene.hand.joints[tip.first_joint + j].drag;
    finger.mobility[j] = 1.0 / (scene.viscosity(k) * drag);
    if (const auto stiffness = scene.control->posture_Nm_per_rad) {
      const FingerVector error = FingerVector::Unit(J.cols(), j);
      finger.posture.col(j) = posture_torques(J, tip.joints, *stiffness, error).head(tip.joints);
    }
  }
  for (int j = 0; tip.followers > 0 && j < tip.joints; ++j)
    finger.posture.row(j) /= finger.mobility[j] * scene.viscosity(k);
  finger.answers = damped(squared(J)).inverse();
  const Vector3d n = contact.axes.col(0);
  const double normal_N = std::max(n.dot(f), 1e-3);
  finger.compliance = pulp_compliance(model_, k, contact.axes, normal_N);
  for (int axis = 0; axis < 3; ++axis) finger.shifts.col(axis) = n.cross(Vector3d::Unit(axis)) / normal_N;
  const Vector3d pulp(scene.control->pulp_normal_N_per_m, scene.control->pulp_tangential_N_per_m,
                      scene.control->pulp_tangential_N_per_m);
  finger.filter = contact.axes * pulp.cwiseInverse().asDiagonal() * contact.axes.transpose();
  if (model_.deformable()) {
    finger.retained = retained_share(model_.pulps[k].material, scene.step_s);
    finger.lag_s = model_.pulps[k].material.relaxation_s;
  }
  fingers_.push_back(finger);
}

int PoseLoop::delay_steps() const {
  const Scene& scene = model_.scene;
  const int steps = steps_of_period(scene);
  const int known = static_cast<int>(ticks_of(model_, scene.control->feedback_delay_s));
  return (known + steps - 1) / steps * steps + static_cast<int>(std::ceil(scene.control_delay_s / scene.step_s - 1e-6));
}

SampledLoop PoseLoop::sampled(const PoseGains& gains, int delay_steps) const {
  SampledLoop loop;
  loop.steps = steps_of_period(model_.scene);
  loop.delay = delay_steps;
  add_plant(loop);
  add_controller(gains, loop);
  return loop;
}

// x = (X, q, w): the object's motion, the joints', and the pulps' wrenches in the last step. As in a contact tick
//     X+ = X + h (B + h k)^-1 (T' w+ - k X),  q+ = q + h b^-1 (tau - J' w+),
//     u+ = J q+ - T X+ = rho u + (1 - rho) C w+,
// B the object's viscosity, k the task's spring, u the pulps' deformations, tau the command.
void PoseLoop::add_plant(SampledLoop& loop) const {
  const Scene& scene = model_.scene;
  const double h = scene.step_s;
  const Index rows = T_.rows(), joints = std::ssize(scene.hand.joints), X = 0, q = 6, w = 6 + joints;
  Vector6d B, spring = Vector6d::Zero();
  B << Vector3d::Constant(scene.object.translation_damping), Vector3d::Constant(scene.object.rotation_damping);
  if (const auto& task = scene.task.spring) {
    spring << Vector3d::Constant(task->translation_N_per_m), Vector3d::Constant(task->rotation_Nm_per_rad);
  }
  const Vector6d moves = (h / (B + h * spring).array()).matrix();
  MatrixXd J = MatrixXd::Zero(rows, joints), gives = MatrixXd::Zero(rows, rows);
  VectorXd turns(joints), goes_on(rows);  // h b^-1, 1 - rho.
  for (Index k = 0; k < std::ssize(fingers_); ++k) {
    const Finger& finger = fingers_[k];
    J.block(6 * k, finger.first, 6, finger.J.cols()) = finger.J;
    turns.segment(finger.first, finger.J.cols()) = h * finger.mobility;
    goes_on.segment<6>(6 * k).setConstant(1.0 - finger.retained);
    gives.block<6, 6>(6 * k, 6 * k) = (1.0 - finger.retained) * finger.compliance;
  }
  const MatrixXd W = gives + J * turns.asDiagonal() * J.transpose() + T_ * moves.asDiagonal() * T_.transpose();
  const Eigen::LDLT<MatrixXd> solve(W);
  MatrixXd by_state = MatrixXd::Zero(rows, w + rows);  // w+ = by_state x + by_command tau.
  by_state.middleCols(X, 6) = solve.solve(T_ * moves.cwiseProduct(spring).asDiagonal() - goes_on.asDiagonal() * T_);
  by_state.middleCols(q, joints) = solve.solve(goes_on.asDiagonal() * J);
  const MatrixXd by_command = solve.solve(J * turns.asDiagonal());
  loop.A = MatrixXd::Identity(w + rows, w + rows);
  loop.B = MatrixXd::Zero(w + rows, joints);
  loop.A.middleRows(w, rows) = by_state;
  loop.B.middleRows(w, rows) = by_command;
  loop.A.middleRows(q, joints) -= turns.asDiagonal() * J.transpose() * by_state;
  loop.B.middleRows(q, joints) = turns.asDiagonal() * (MatrixXd::Identity(joints, joints) - J.transpose() * by_command);
  loop.A.topRows(6) += moves.asDiagonal() * T_.transpose() * by_state;
  loop.A.topLeftCorner(6, 6).diagonal() -= moves.cwiseProduct(spring);
  loop.B.topRows(6) = moves.asDiagonal() * T_.transpose() * by_command;
}

// z = (y, I, e): the force control's filter, the PID's integral and its last error. The command is tau of eq. (22),
// with the posture's.
void PoseLoop::add_controller(const PoseGains& gains, SampledLoop& loop) const {
  Scene scene = model_.scene;
  scene.control_delay_s = loop.delay * scene.step_s;
  scene.control->feedback_delay_s = 0.0;
  const double period_s = loop.steps * scene.step_s;
  const Index rows = T_.rows() / 2, states = loop.A.rows(), joints = loop.B.cols(), q = 6, w = q + joints;
  const Index y = 0, I = rows, e = rows + 6;
  Matrix6d to_centre = Matrix6d::Identity();
  if (gains.centre_m) to_centre.topRows<3>() = motion_at(X_WO_.linear() * *gains.centre_m);
  const auto six = [](double position, double rotation) {
    Vector6d all;
    all << Vector3d::Constant(position), Vector3d::Constant(rotation);
    return all;
  };
  const Vector6d p = six(gains.position.p, gains.rotation.p), i = six(gains.position.i, gains.rotation.i),
                 d = six(gains.position.d, gains.rotation.d) / period_s;
  loop.Ac = MatrixXd::Zero(rows + 12, rows + 12);
  loop.Bc = MatrixXd::Zero(rows + 12, states);
  // Of an integral that no gain acts on the loop knows nothing.
  const Vector6d counts = (i.array() != 0.0).cast<double>();
  loop.Ac.block<6, 6>(I, I).diagonal() = counts;
  loop.Bc.block<6, 6>(I, 0) = -period_s * counts.asDiagonal() * to_centre;
  loop.Bc.block<6, 6>(e, 0) = -to_centre;
  // f^d by memory and state, and f^d - f.
  const MatrixXd to_forces = by_wrench_ * to_centre.transpose();
  MatrixXd f_z = MatrixXd::Zero(rows, rows + 12), f_x = MatrixXd::Zero(rows, states);
  f_z.middleCols(I, 6) = to_forces * i.asDiagonal();
  f_z.middleCols(e, 6) = -to_forces * d.asDiagonal();
  f_x.leftCols(6) = -to_forces * (p + d + period_s * i).asDiagonal() * to_centre;
  for (int k = 0; k < std::ssize(fingers_); ++k) {
    f_x.middleCols<3>(w + 6 * k + 3) = by_points_.middleCols<3>(3 * k) * fingers_[k].shifts;
  }
  MatrixXd off_x = f_x;
  for (int k = 0; k < std::ssize(fingers_); ++k) off_x.block<3, 3>(3 * k, w + 6 * k).diagonal().array() -= 1.0;
  const double forward = scene.control->law == ControlLaw::kFeedforward ? 1.0 : 0.0;
  loop.Cc = MatrixXd::Zero(joints, rows + 12);
  loop.Dc = MatrixXd::Zero(joints, states);
  for (int k = 0; k < std::ssize(fingers_); ++k) {
    const Finger& finger = fingers_[k];
    const double lag = finger.lag_s / period_s;
    const Matrix3d acts = finger.filter / (1.0 + lag), answers = force_gain(scene, k) * finger.answers;
    const Index at = 3 * k, own = finger.J.cols();
    loop.Ac.middleRows<3>(y + at) = acts * f_z.middleRows<3>(at);
    loop.Ac.block<3, 3>(y + at, y + at) += lag / (1.0 + lag) * Matrix3d::Identity();
    loop.Bc.middleRows<3>(y + at) = acts * off_x.middleRows<3>(at);
    const MatrixXd to_torques = finger.J.topRows<3>().transpose();
    loop.Cc.middleRows(finger.first, own) =
        to_torques * (forward * f_z.middleRows<3>(at) + answers * loop.Ac.middleRows<3>(y + at));
    loop.Dc.middleRows(finger.first, own) =
        to_torques * (forward * f_x.middleRows<3>(at) + answers * loop.Bc.middleRows<3>(y + at));
    loop.Dc.block(finger.first, q + finger.first, own, own) -= finger.posture;
  }
}

PoseMode PoseLoop::slowest(const PoseGains& gains, int delay_steps) const {
  const SlowestPole found = slowest_pole(sampled(gains, delay_steps), 6);
  PoseMode mode;
  mode.pole = found.radius;
  const Eigen::Vector3cd turn = found.state.segment<3>(3);
  const Eigen::Vector3cd goes = motion_at(centroid_m_) * found.state.head<6>();
  mode.turns = lever_m_ * turn.norm() > goes.norm();
  mode.axis_O = X_WO_.linear().transpose() * axis_of(mode.turns ? turn : goes);
  return mode;
}

double PoseLoop::most_gain(const PoseGains& gains, int delay_steps, Of which) const {
  constexpr double kLeast = 1e-3, kMost = 1e4, kAccuracy = 1.01;
  const auto holds = [&](double times) {
    const PoseGains some = gains.times(which == Of::kRotation ? 1.0 : times, which == Of::kPosition ? 1.0 : times);
    return slowest(some, delay_steps).is_stable();
  };
  double low = 1.0, high = 1.0;
  if (holds(1.0)) {
    do {
      low = high;
      high *= 2.0;
    } while (high < kMost && holds(high));
    if (high >= kMost) return kMost;
  } else {
    do {
      high = low;
      low *= 0.5;
    } while (low > kLeast && !holds(low));
    if (low <= kLeast) return 0.0;
  }
  while (high > kAccuracy * low) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

int PoseLoop::most_delay(const PoseGains& gains, int multiple) const {
  const int most = static_cast<int>(1.0 / (model_.scene.step_s * multiple));
  const auto holds = [&](int delay) { return slowest(gains, multiple * delay).is_stable(); };
  if (!holds(0)) return -1;
  int low = 0, high = 1;
  while (high <= most && holds(high)) {
    low = high;
    high *= 2;
  }
  if (high > most) return multiple * most;
  while (high > low + 1) {
    const int middle = (low + high) / 2;
    (holds(middle) ? low : high) = middle;
  }
  return multiple * low;
}

void Swings::Course::add(double now, double least) {
  const double on = way * (now - far);
  if (way == 0 && std::abs(now - far) > least) way = now > far ? 1 : -1;
  if (way != 0 && on >= 0.0) far = now;
  if (!(on < -0.1 * least)) return;
  // It reverses. For an angle, which has no sign, two swings are one: there and back.
  const double size = std::abs(far - turned);
  wider = one_before > 0.0 && size > least && size > kWider * kWider * one_before ? wider + 1 : 0;
  if (wider == 0) first = size;
  one_before = last;
  last = size;
  turned = far;
  far = now;
  way = -way;
}

std::optional<Swings::Swing> Swings::add(const Vector3d& off_m, double off_rad) {
  for (int i = 0; i < 4; ++i) {
    const bool turns = i == 3;
    Course& course = courses_[i];
    course.add(turns ? off_rad : off_m[i], turns ? kLeast_rad : kLeast_m);
    if (course.wider >= kOnEnd && course.last > kGrown * course.first) return Swing{turns, course.last};
  }
  return std::nullopt;
}

}  // namespace thenar
