// SPDX-License-Identifier: Apache-2.0
#include "engine/control/stiff_control.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

// Postures that the object does not stabilise diverge in b over this: 5 s for usual joints.
constexpr double kPosture_Nm_per_rad = 0.01;
// Effort of a newton of internal force itself: nearly none, as muscles account for it.
constexpr double kSqueezeWeight = 1e-3;
constexpr double kSqueeze_N_per_s = 20.0;  // Largest rate of change, the bound of a period's choice.
constexpr double kLeastLoad_N = 0.1;       // Below this a patch is too small to predict its growth.
// Successive factors on the last period's share; and the time until it grows again, and its rate.
constexpr std::array kTries{1.0, 0.97, 0.85, 0.6};
constexpr double kPause_s = 0.1, kMore_per_s = 1.0;
const double kUsualArm_m = StiffMuscleData().length_m;  // If only one kind of stiffness is demanded.

/// Returns the arm that scales rotations to translations.
double arm_m(const ObjectStiffness& wanted) {
  const double translation = wanted.translation_N_per_m.mean(), rotation = wanted.rotation_Nm_per_rad.mean();
  if (!(translation > 0.0 && rotation > 0.0)) return kUsualArm_m;
  return std::clamp(std::sqrt(rotation / translation), 5e-3, 0.1);
}

}  // namespace

StiffMuscleData stiff_problem(const Scene& scene) {
  const Hand& hand = scene.hand;
  const auto joints = std::ssize(hand.joints), muscles = std::ssize(hand.muscles);
  StiffMuscleData problem;
  Index pairs = 0;
  for (const Fingertip& tip : hand.fingertips) {
    problem.joints.push_back(tip.joints);
    pairs += tip.joints * (tip.joints + 1) / 2;
  }
  problem.H.setZero(joints, muscles);
  problem.arm.setZero(joints, muscles);
  problem.turn.setZero(pairs, muscles);
  problem.tau.setZero(joints);
  problem.B.setZero(6, joints);
  problem.D.setZero(joints, joints);
  problem.limit.resize(muscles);
  problem.fibre_per_m.resize(muscles);
  problem.tendon_N_per_m.resize(muscles);
  for (Index m = 0; m < muscles; ++m) {
    problem.limit[m] = hand.muscles[m].max_force_N;
    problem.fibre_per_m[m] = *scene.control->muscles->short_range / *hand.muscles[m].fibre_m;
    problem.tendon_N_per_m[m] = hand.muscles[m].tendon_N_per_m;
  }
  problem.kappa = kPosture_Nm_per_rad;
  if (const auto& wanted = scene.control->muscles->object_stiffness) problem.length_m = arm_m(*wanted);
  return problem;
}

void set_grasp(const Hand& hand, std::span<const Belly> bellies, const GraspStiffness& grasp,
               StiffMuscleData& problem) {
  for (const Belly& belly : bellies) {
    const Fingertip& tip = hand.fingertips[belly.finger];
    const auto arms = belly.arms_m.head(tip.joints);
    problem.H.col(belly.muscle).segment(tip.first_joint, tip.joints) = arms;
    problem.arm.col(belly.muscle).segment(tip.first_joint, tip.joints) = arms / std::sqrt(belly.share);
    Index row = 0;
    for (int k = 0; k < belly.finger; ++k) row += hand.fingertips[k].joints * (hand.fingertips[k].joints + 1) / 2;
    for (int i = 0; i < tip.joints; ++i) {
      for (int j = 0; j <= i; ++j) problem.turn(row++, belly.muscle) = belly.slopes_m(i, j);
    }
  }
  problem.A = 0.5 * (grasp.A + grasp.A.transpose());
  for (int k = 0; k < hand.fingers(); ++k) {
    const Fingertip& tip = hand.fingertips[k];
    problem.B.middleCols(tip.first_joint, tip.joints) = 0.5 * (grasp.B[k] + grasp.B_joints[k]);
    problem.D.block(tip.first_joint, tip.first_joint, tip.joints, tip.joints) =
        0.5 * (grasp.D[k] + grasp.D[k].transpose());
  }
}

void tell_lack(const StiffLack& lack, StiffCause cause, double length_m, const Matrix6d& not_tried,
               const Eigen::Isometry3d& X_WO, StiffnessReport& report) {
  if (cause == StiffCause::kTorques) return;
  report.at_limit = lack.at_limit;
  if (cause != StiffCause::kStiffness) return;
  const Vector3d along = lack.direction.head<3>(), about = lack.direction.tail<3>() / length_m;
  Vector6d motion;
  motion << along, about;
  report.rotates = length_m * about.norm() > along.norm();
  report.axis_O = X_WO.linear().transpose() * (report.rotates ? about : along).normalized();
  // The motion is of both kinds: the whole lack counts for the one that is named.
  const double named = report.rotates ? about.squaredNorm() : along.squaredNorm();
  report.lacking = (lack.lacking_N_per_m + motion.dot(not_tried * motion)) / named;
}

StiffnessControl::StiffnessControl(const Model& model)
    : work_(model), problem_(stiff_problem(model.scene)), load_N_(model.fingers()) {
  places_.reserve(model.max_contacts);
  if (!(model.scene.control->muscles->object_stiffness->most_squeeze_N > 0.0)) return;
  const auto joints = std::ssize(model.scene.hand.joints);
  StiffSqueeze& squeeze = problem_.squeeze.emplace();
  squeeze.tau.setZero(joints);
  squeeze.B.setZero(6, joints);
  squeeze.D.setZero(joints, joints);
  squeeze.weight = kSqueezeWeight;
}

void StiffnessControl::look(const Model& model, const Frame& frame, const HandPose& pose, const Snapshot& snapshot) {
  is_loaded_ = std::ranges::all_of(snapshot.load, [](const FingerLoad& load) { return load.normal_N > 0.0; });
  if (!is_loaded_) return;
  const double now_s = static_cast<double>(snapshot.tick) * model.scene.step_s;
  places_of(frame, pose, model.scene.hand, places_);
  grasp_ = grasp_stiffness(model, frame, pose, {snapshot.contact_forces, places_, model.friction(now_s)},
                           model.gravity(now_s), work_);
  is_loaded_ = grasp_.contacts > 0;  // In a state of another model forces are not known yet.
  const ObjectStiffness& wanted = *model.scene.control->muscles->object_stiffness;
  // Another choice: the last one's warm start is on another arm.
  if (const double arm = arm_m(wanted); arm != problem_.length_m) {
    problem_.length_m = arm;
    last_.is_set = false;
  }
  wanted_ = wanted_stiffness(wanted, snapshot.X_WO);
  X_WO_ = snapshot.X_WO;
  centre_m_ = X_WO_.linear() * wanted.centre_m;
  for (std::size_t k = 0; k < load_N_.size(); ++k) load_N_[k] = snapshot.load[k].normal_N;
}

Matrix6d StiffnessControl::in_object(const Matrix6d& K_W) const {
  const Matrix6d K = about(K_W, centre_m_);
  const Eigen::Matrix3d R = X_WO_.linear();
  Matrix6d K_O;
  for (int i = 0; i < 6; i += 3) {
    for (int j = 0; j < 6; j += 3) K_O.block<3, 3>(i, j) = R.transpose() * K.block<3, 3>(i, j) * R;
  }
  return K_O;
}

/// Computes the changes per newton of internal force: forces of constant direction at their points, and pulps. A pulp
/// under the normal load N is as stiff as its patch is wide: as N^(1/3) E^(2/3) [Hertz], with E that may grow with N,
/// too.
void StiffnessControl::set_squeeze(const Model& model, const HandPose& pose, const PerFinger<GraspContact>& contacts,
                                   const FingerForces& more_N, double period_s) {
  StiffSqueeze& squeeze = *problem_.squeeze;
  const Hand& hand = model.scene.hand;
  squeeze.A.setZero();
  for (int k = 0; k < hand.fingers(); ++k) {
    const Fingertip& tip = hand.fingertips[k];
    const Index first = tip.first_joint, n = tip.joints;
    const Vector3d f = more_N.col(k);
    const FingerJacobian J = finger_jacobian(hand, pose, k, contacts[k].point_m);
    squeeze.tau.segment(first, n) = J.leftCols(n).transpose().lazyProduct(f);
    squeeze.A.bottomRightCorner<3, 3>() += turning_stiffness(f, contacts[k].point_m - X_WO_.translation());
    squeeze.D.block(first, first, n, n) =
        force_stiffness(hand, pose, hand.segments[tip.segment], contacts[k].point_m, f);
    if (!model.deformable()) continue;
    const double beta = model.pulps[k].material.stiffening_per_N, N = std::max(kLeastLoad_N, load_N_[k]);
    const double growth = contacts[k].axes.col(0).dot(f) * (1.0 / (3.0 * N) + 2.0 / 3.0 * beta / (1.0 + beta * N));
    ObjectJoints L(6, n);  // The finger's motion at the object's origin.
    L.topRows<3>() = finger_jacobian(hand, pose, k, X_WO_.translation()).leftCols(n);
    L.bottomRows<3>() = turning_axes(hand, pose, k).leftCols(n);
    const Matrix6d pulp = growth * grasp_.pulps[k];
    squeeze.A += pulp;
    squeeze.B.middleCols(first, n) = pulp.lazyProduct(L);
    squeeze.D.block(first, first, n, n) += L.transpose().lazyProduct(squeeze.B.middleCols(first, n));
  }
  const double step_N = kSqueeze_N_per_s * period_s;
  const double room_N = model.scene.control->muscles->object_stiffness->most_squeeze_N - squeeze_N_;
  squeeze.low = -std::min(step_N, std::max(0.0, squeeze_N_));
  squeeze.high = std::min(step_N, std::max(0.0, room_N));
}

bool StiffnessControl::choose(const Model& model, std::span<const Belly> bellies, const JointVector& tau,
                              const HandPose& pose, const PerFinger<GraspContact>& contacts, const FingerForces& more_N,
                              double period_s, Eigen::Ref<Eigen::VectorXd> f, StiffnessReport& report) {
  report = StiffnessReport{.squeeze_N = squeeze_N_};
  if (!is_loaded_) return false;
  report.is_chosen = true;
  set_grasp(model.scene.hand, bellies, grasp_, problem_);
  problem_.tau = tau;
  if (problem_.squeeze) set_squeeze(model, pose, contacts, more_N, period_s);
  find_forces(period_s, f, report);
  return report.share > 0.0;
}

void StiffnessControl::find_forces(double period_s, Eigen::Ref<Eigen::VectorXd> f, StiffnessReport& report) {
  double next = share_;
  for (const double less : kTries) {
    const double share = less * share_;
    problem_.K_des = share * wanted_;
    const StiffMuscleProblem problem = problem_;
    const StiffMuscleReport found = solve_stiff_muscles(problem, last_, f);
    report.iterations += found.iterations;
    report.residual = found.residual;
    if (found.status == MuscleStatus::kOptimal) {
      report.share = next = share;
      Matrix6d K_W;
      if (object_stiffness(problem, f, found.squeeze, K_W)) report.K_O = in_object(K_W);
      squeeze_N_ += found.squeeze;
      break;
    }
    report.is_unanswered |= found.status == MuscleStatus::kBudgetSpent;
    if (found.cause == StiffCause::kTorques) return;  // Reported by the least forces.
    if (found.status == MuscleStatus::kInfeasible && !report.is_infeasible) {
      tell_lack(stiff_lack(problem, found), found.cause, problem.length_m, (1.0 - share) * wanted_, X_WO_, report);
      report.is_infeasible = true;
    }
    if (found.cause != StiffCause::kPosture) {
      next = share;
    } else if (found.status == MuscleStatus::kInfeasible) {
      break;  // The proof weighs torques and postures alone: no share helps.
    }
  }
  if (report.share < share_) {
    share_ = next;
    waits_s_ = kPause_s;
  } else if (waits_s_ > 0.0) {
    waits_s_ -= period_s;
  } else {
    share_ = std::min(1.0, share_ + kMore_per_s * period_s);
  }
}

}  // namespace thenar
