// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/effort.h"

#include <algorithm>

#include "engine/hand/muscles.h"
#include "solvers/grasp_forces.h"
#include "solvers/muscles/muscle_forces.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kMostForce = 100.0;  // Largest ratio of forces to the commanded wrench, as in control_period.cpp.

}  // namespace

std::vector<Vector3d> directions() {
  std::vector<Vector3d> all;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (const int n = x * x + y * y + z * z; n == 1 || n == 3) all.push_back(Vector3d(x, y, z).normalized());
      }
    }
  }
  return all;
}

ForceCheck::ForceCheck(const FinderProblem& problem, const std::vector<GraspContact>& contacts,
                       const Eigen::Isometry3d& X_WO, double internal_force_N)
    : contacts_(contacts), lever_m_(X_WO.linear() * problem.centre_of_mass_m) {
  problem_ = {.contacts = contacts_,
              .centre_m = X_WO.translation(),
              .wrench = Vector6d::Zero(),
              .friction = problem.cone_friction,
              .cone = problem.cone,
              .internal_force_N = internal_force_N};
}

HoldingForces ForceCheck::against(const Vector3d& force_N, const Vector3d& moment_Nm) {
  problem_.wrench.head<3>() = -force_N;
  problem_.wrench.tail<3>() = -(lever_m_.cross(force_N) + moment_Nm);
  HoldingForces result;
  result.f = VectorXd::Zero(3 * std::ssize(contacts_));
  result.found = solve_grasp_forces(problem_, result.f).status == GraspStatus::kOptimal;
  const double asked_N = problem_.internal_force_N + force_N.norm() + problem_.wrench.tail<3>().norm() / 1e-2;
  if (result.f.norm() > kMostForce * asked_N) result.found = false;
  if (!result.found) {
    result.f.setZero();
    result.needed_friction = std::numeric_limits<double>::infinity();
    return result;
  }
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const Vector3d f_C = contacts_[k].axes.transpose() * result.f.segment<3>(3 * static_cast<Index>(k));
    if (f_C.tail<2>().norm() == 0.0) continue;
    result.needed_friction = std::max(result.needed_friction, f_C.tail<2>().norm() / std::max(f_C[0], 1e-12));
  }
  return result;
}

JointVector Effort::torques_Nm(const JointVector& q, const VectorXd& f) {
  forward_kinematics(hand_, q, pose_);
  JointVector tau = gravity_torques(hand_, pose_, gravity_);
  for (int k = 0; k < hand_.fingers(); ++k) {
    const Fingertip& tip = hand_.fingertips[k];
    const FingerJacobian J = finger_jacobian(hand_, pose_, k, contacts_[k].point_m);
    tau.segment(tip.first_joint, tip.joints) += J.leftCols(tip.joints).transpose() * f.segment<3>(3 * k);
  }
  return tau;
}

double Effort::muscle_share(const JointVector& tau) {
  if (!problem_.muscles || hand_.muscles.empty()) return 0.0;
  const Index muscles = std::ssize(hand_.muscles);
  MuscleData data{Eigen::MatrixXd::Zero(tau.size(), muscles), tau};
  moment_arms(hand_, pose_, data.H);
  VectorXd f = VectorXd::Zero(muscles);
  if (solve_muscle_forces(data, f).status != MuscleStatus::kOptimal) return std::numeric_limits<double>::infinity();
  double share = 0.0;
  for (Index m = 0; m < muscles; ++m) share = std::max(share, f[m] / std::max(1e-9, hand_.muscles[m].max_force_N));
  return share;
}

}  // namespace thenar
