// SPDX-License-Identifier: Apache-2.0
#include "engine/stiffness/object_stiffness.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "engine/stiffness/slipping.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// Probes move micrometres: contacts must not err by a thousandth of that.
constexpr double kTolerance = 1e-9;
constexpr int kLeastSweeps = 1000;
constexpr double kNearlySlides = 0.99;  // Share of its friction with which a contact nearly slides.

/// Freezes the task at this time.
void hold_task(const Model& of, double at_s, Scene& scene) {
  TaskSettings& task = scene.task;
  const double last_s = at_s - 0.5 * scene.step_s;
  const Eigen::Isometry3d moved = of.scene.object.X_WO.inverse() * of.target(at_s);
  if (task.translate)
    task.translate = Move{task.translate->axis, moved.translation().dot(task.translate->axis), -1.0, 0.5};
  if (task.rotate) {
    const Eigen::AngleAxisd turn(Matrix3d(moved.linear()));
    task.rotate = Move{task.rotate->axis, turn.angle() * turn.axis().dot(task.rotate->axis), -1.0, 0.5};
  }
  if (auto& push = task.push; push && last_s >= push->from_s && last_s < push->from_s + push->over_s) {
    const double share = push->rise_s > 0.0 ? std::min(1.0, (last_s - push->from_s) / push->rise_s) : 1.0;
    push = Push{share * push->force_N,  0.0, std::numeric_limits<double>::infinity(), 0.0, push->at_m,
                share * push->moment_Nm};
  } else {
    push.reset();
  }
  scene.gravity = of.gravity(at_s);
  task.arm.reset();
  scene.contact.friction = of.friction(at_s);
  task.friction.clear();
  if (!scene.environment) return;
  for (EnvironmentBody& body : scene.environment->bodies) {
    body.X_WE = pose(body, at_s);
    body.moves.clear();
  }
}

Model to_be_probed(const Model& of, double at_s, Acting acting) {
  Model model = of;
  hold_task(of, at_s, model.scene);
  model.scene.contact.tolerance = std::min(model.scene.contact.tolerance, kTolerance);
  model.scene.contact.max_sweeps = std::max(model.scene.contact.max_sweeps, kLeastSweeps);
  if (acting == Acting::kMuscles) model.scene.control->muscles->frozen_from_s = at_s - 0.5 * model.scene.step_s;
  return model;
}

Matrix3d symmetric(const Matrix3d& M) { return 0.5 * (M + M.transpose()); }

/// The stiffness S of the forces on (object, joints), and the viscosity V against their speeds: the viscosities, and
/// the pulps', which are Kelvin and Voigt's: relaxation times stiffness.
struct Dynamics {
  MatrixXd S, V;
  VectorXd b;  ///< The diagonal of V without the pulps.
};

Dynamics dynamics(const Model& model, const HandPose& pose, const Vector3d& origin_m, const GraspStiffness& grasp,
                  const PerFinger<JointMatrix>& muscles) {
  const Scene& scene = model.scene;
  const Index size = 6 + std::ssize(scene.hand.joints);
  Dynamics all{MatrixXd::Zero(size, size), {}, VectorXd(size)};
  all.b.head<3>().setConstant(scene.object.translation_damping);
  all.b.segment<3>(3).setConstant(scene.object.rotation_damping);
  all.S.topLeftCorner<6, 6>() = grasp.A;
  MatrixXd pulps = MatrixXd::Zero(size, size);
  for (int k = 0; k < model.fingers(); ++k) {
    const Fingertip& tip = scene.hand.fingertips[k];
    const Index row = 6 + tip.first_joint, n = tip.joints;
    for (Index j = 0; j < n; ++j) all.b[row + j] = scene.viscosity(k) * scene.hand.joints[tip.first_joint + j].drag;
    all.S.block(0, row, 6, n) = -grasp.B[k];
    all.S.block(row, 0, n, 6) = -grasp.B_joints[k].transpose();
    all.S.block(row, row, n, n) = grasp.D[k] + muscles[k];
    if (!model.deformable()) continue;
    // The motion of the object against the finger, both at the object's origin: X - L q.
    MatrixXd against = MatrixXd::Zero(6, size);
    against.leftCols<6>().setIdentity();
    against.block(0, row, 3, n) = -finger_jacobian(scene.hand, pose, k, origin_m).leftCols(n);
    against.block(3, row, 3, n) = -turning_axes(scene.hand, pose, k).leftCols(n);
    pulps += model.pulps[k].material.relaxation_s * against.transpose() * grasp.pulps[k] * against;
  }
  all.V = pulps;
  all.V.diagonal() += all.b;
  return all;
}

void name_mode(const Model& model, const VectorXd& b, const VectorXd& motion, const Matrix3d& R_WO, GraspMode& mode) {
  const VectorXd taken = b.cwiseProduct(motion.cwiseAbs2());
  const auto candidate = [&](Moving moving, int finger, double most) {
    if (const double share = most / taken.sum(); share > mode.share) {
      mode.share = share;
      mode.moving = moving;
      mode.finger = finger;
    }
  };
  candidate(Moving::kTranslation, 0, taken.head<3>().sum());
  candidate(Moving::kRotation, 0, taken.segment<3>(3).sum());
  for (int k = 0; k < model.fingers(); ++k) {
    const Fingertip& tip = model.scene.hand.fingertips[k];
    candidate(Moving::kFinger, k, taken.segment(6 + tip.first_joint, tip.joints).sum());
  }
  if (mode.moving == Moving::kFinger) return;
  mode.axis_O = R_WO.transpose() * motion.segment<3>(mode.moving == Moving::kTranslation ? 0 : 3).normalized();
  Index most = 0;
  mode.axis_O.cwiseAbs().maxCoeff(&most);
  if (mode.axis_O[most] < 0.0) mode.axis_O = -mode.axis_O;
}

/// Returns the modes of V dz/dt = -S z: z = sum of modes exp(-rate t).
std::vector<GraspMode> modes_of(const Model& model, const Dynamics& all, const Matrix3d& R_WO) {
  const MatrixXd inverse = all.V.inverse();
  const Eigen::EigenSolver<MatrixXd> solver(inverse * all.S);
  const Eigen::MatrixXcd right = solver.eigenvectors(), left = right.inverse();
  std::vector<GraspMode> modes;
  for (Index i = 0; i < right.cols(); ++i) {
    GraspMode mode;
    mode.rate_per_s = solver.eigenvalues()[i].real();
    mode.swings_rad_per_s = std::abs(solver.eigenvalues()[i].imag());
    mode.measure = left.row(i).transpose();
    mode.pushed_by = (left.row(i) * inverse).real().head<6>().transpose();
    name_mode(model, all.b, right.col(i).real(), R_WO, mode);
    modes.push_back(std::move(mode));
  }
  std::ranges::stable_sort(modes, {}, &GraspMode::rate_per_s);
  return modes;
}

MuscleEffort effort_of(const Hand& hand, const MuscleVector& forces_N) {
  MuscleEffort effort{.sum_N = forces_N.sum()};
  for (int m = 0; m < std::ssize(hand.muscles); ++m) {
    const double share = forces_N[m] / hand.muscles[m].max_force_N;
    if (share > effort.share) effort = {effort.sum_N, m, share};
  }
  return effort;
}

/// Returns the stiffness of a finger's muscles whose joints are turned by q - q_0 from where the forces f are theirs.
/// By the contact tick's law they drive the joints by h (f + x), x = -k h'(q - q_0), of fibres that have yielded a part
/// of f: minus its derivative by q, with which the arms h change.
JointMatrix lengthened_stiffness(const Scene& scene, std::span<const Belly> bellies, int finger,
                                 const MuscleVector& forces_N, const JointVector& turned_rad) {
  const MuscleSettings& settings = *scene.control->muscles;
  const double gamma = *settings.short_range;
  const Fingertip& tip = scene.hand.fingertips[finger];
  const auto turned = turned_rad.segment(tip.first_joint, tip.joints);
  JointMatrix K = JointMatrix::Zero(tip.joints, tip.joints);
  for (const Belly& belly : bellies) {
    if (belly.finger != finger) continue;
    const double f_N = forces_N[belly.muscle], k = belly_stiffness(scene.hand, belly, gamma, f_N);
    const auto h = belly.arms_m.head(tip.joints);
    const auto slopes = belly.slopes_m.topLeftCorner(tip.joints, tip.joints);
    const double elastic_N = -k * h.dot(turned);
    const auto yielded = yielded_N(gamma, settings.short_range_strain, f_N, elastic_N);
    if (!yielded) K += k * h * (h + slopes * turned).transpose();
    K -= (f_N + yielded.value_or(elastic_N)) * slopes;
  }
  return K;
}

/// Returns the mean of two stiffnesses of a grasp's contacts.
GraspStiffness mean(const GraspStiffness& one, const GraspStiffness& other) {
  GraspStiffness all = one;
  all.A = 0.5 * (one.A + other.A);
  for (std::size_t k = 0; k < one.B.size(); ++k) {
    all.B[k] = 0.5 * (one.B[k] + other.B[k]);
    all.B_joints[k] = 0.5 * (one.B_joints[k] + other.B_joints[k]);
    all.D[k] = 0.5 * (one.D[k] + other.D[k]);
    all.pulps[k] = 0.5 * (one.pulps[k] + other.pulps[k]);
  }
  return all;
}

PredictedStiffness predict(const GraspRun& run, const MuscleVector& forces_N, bool lengthened) {
  const Model& model = run.model;
  const Hand& hand = model.scene.hand;
  const SeenRun seen(run);
  const GraspRun& at = seen.at;
  ContactKinematics now(model);
  contact_kinematics(model, at.frame, seen.pose, at.state, now);
  const std::vector<ContactPlace> places = places_of(now, at.frame.size());
  PerFinger<FingerSlips> slips, more_slips;
  const GraspStiffness sticking = seen.sticking(places, 1.0, slips);
  (void)seen.sticking(places, kNearlySlides, more_slips);
  const GraspStiffness grasp = mean(seen.grasp(places), sticking);

  PredictedStiffness all;
  const JointVector turned_rad = lengthened ? JointVector(at.state.q - at.frame.q_rest) : hand.at_zero();
  PerFinger<JointMatrix> muscles(model.fingers());
  all.joints_Nm_per_rad = PerFinger<double>(model.fingers());
  for (int k = 0; k < model.fingers(); ++k) {
    muscles[k] = lengthened_stiffness(model.scene, at.frame.bellies, k, forces_N, turned_rad);
    const MatrixXd joints = grasp.D[k] + muscles[k];
    const MatrixXd even = 0.5 * (joints + joints.transpose());
    all.joints_Nm_per_rad[k] = Eigen::SelfAdjointEigenSolver<MatrixXd>(even).eigenvalues()[0];
  }
  all.X_WO = at.state.X_WO;
  const SlippingCompliance slipping = slipping_compliance(sticking, slips, muscles, all.X_WO.linear());
  const SlippingCompliance more = slipping_compliance(sticking, more_slips, muscles, all.X_WO.linear());
  all.K_O = slipping.C_O.inverse();
  all.contacts = grasp.contacts;
  all.sliding = grasp.sliding;
  for (const FingerSlips& finger : more_slips) all.near_sliding += static_cast<int>(finger.G.rows());
  all.uncertain = compliance_error(more.C_O, slipping.C_O);
  if (!slipping.is_solved || !more.is_solved) all.uncertain = std::max(all.uncertain, 1.0);
  all.effort = effort_of(hand, forces_N);
  const Dynamics laws = dynamics(model, seen.pose, all.X_WO.translation(), grasp, muscles);
  all.modes = modes_of(model, laws, all.X_WO.linear());
  return all;
}

}  // namespace

GraspAt::GraspAt(const Model& of, double at_s, Acting acting) : model(to_be_probed(of, at_s, acting)), run(model) {
  GraspRun until(of);
  while (until.time_s() < at_s - 0.5 * of.scene.step_s) until.tick();
  run.go_on_as(until);
  if (!run.controller.task) return;
  run.controller.task->freeze();
  run.state.arm = {run.controller.task->arm().number, arm_m(run.state.arm, run.time_s())};
}

SeenRun::SeenRun(const GraspRun& run) : at(run.model) {
  at.go_on_as(run);
  at.control();
  forward_kinematics(run.model.scene.hand, at.state.q, pose);
}

GraspStiffness SeenRun::grasp(std::span<const ContactPlace> places) const {
  StiffnessWorkspace work(at.model);
  const ContactLoads loads{at.state.forces, places, at.model.friction(at.time_s())};
  return grasp_stiffness(at.model, at.frame, pose, loads, at.model.gravity(at.time_s()), work);
}

GraspStiffness SeenRun::sticking(std::span<const ContactPlace> places, double share,
                                 PerFinger<FingerSlips>& slips) const {
  const ContactLoads loads{at.state.forces, places, at.model.friction(at.time_s())};
  return sticking_stiffness(at.model, at.frame, pose, loads, at.model.gravity(at.time_s()), share, slips);
}

CentredStiffness centred(const Matrix6d& K) {
  CentredStiffness all;
  const Matrix3d K_tt = symmetric(K.topLeftCorner<3, 3>());
  const Eigen::SelfAdjointEigenSolver<Matrix3d> translation(K_tt);
  all.has_centre = translation.eigenvalues()[0] > 1e-9 * translation.eigenvalues()[2];
  if (all.has_centre) {
    const Matrix3d K_tr = 0.5 * (K.topRightCorner<3, 3>() + K.bottomLeftCorner<3, 3>().transpose());
    const Matrix3d M = K_tt.inverse() * K_tr;
    all.centre_m = -0.5 * Vector3d(M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1));
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> rotation(symmetric(about(K, all.centre_m).bottomRightCorner<3, 3>()));
  all.translation_N_per_m = translation.eigenvalues();
  all.translation_axes = translation.eigenvectors();
  all.rotation_Nm_per_rad = rotation.eigenvalues();
  all.rotation_axes = rotation.eigenvectors();
  return all;
}

double compliance_error(const Matrix6d& measured, const Matrix6d& predicted) {
  const Vector6d by = predicted.diagonal().cwiseAbs().cwiseSqrt().cwiseInverse();
  return (by.asDiagonal() * (measured - predicted) * by.asDiagonal()).cwiseAbs().maxCoeff();
}

PredictedStiffness predict_stiffness(const GraspRun& run) { return predict(run, run.state.muscle_N, true); }

PredictedStiffness predict_stiffness(const GraspRun& run, const MuscleVector& forces_N) {
  return predict(run, forces_N, false);
}

}  // namespace thenar
