// SPDX-License-Identifier: Apache-2.0
#include "engine/stiffness/slipping.h"

#include <Eigen/LU>

#include "solvers/lcp.h"

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// All slips of a grasp, its joints in equilibrium: they add Q lambda to the forces that restore the object, and
/// w = V X + G lambda.
struct Slips {
  MatrixXd Q, V, G;
};

Slips with_joints_in_equilibrium(const GraspStiffness& sticking, const PerFinger<FingerSlips>& slips,
                                 const PerFinger<JointMatrix>& muscles) {
  Index count = 0;
  for (const FingerSlips& finger : slips) count += finger.G.rows();
  Slips all{MatrixXd(6, count), MatrixXd(count, 6), MatrixXd::Zero(count, count)};
  Index at = 0;
  for (std::size_t k = 0; k < slips.size(); ++k) {
    const FingerSlips& finger = slips[k];
    const Index n = finger.G.rows();
    if (n == 0) continue;
    // q = D^-1 (B_joints' X + Q_q lambda).
    const Eigen::PartialPivLU<MatrixXd> joints(MatrixXd(sticking.D[k] + muscles[k]));
    const MatrixXd by_object = joints.solve(MatrixXd(sticking.B_joints[k].transpose()));
    const MatrixXd by_slips = joints.solve(finger.Q_q);
    all.Q.middleCols(at, n) = finger.Q_X - sticking.B[k] * by_slips;
    all.V.middleRows(at, n) = finger.V_X - finger.V_q * by_object;
    all.G.block(at, at, n, n) = finger.G - finger.V_q * by_slips;
    at += n;
  }
  return all;
}

}  // namespace

SlippingCompliance slipping_compliance(const GraspStiffness& sticking, const PerFinger<FingerSlips>& slips,
                                       const PerFinger<JointMatrix>& muscles, const Eigen::Matrix3d& R_WO) {
  Matrix6d R = Matrix6d::Zero();
  R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() = R_WO;
  const Matrix6d C = sticking.of_object(muscles).inverse();
  const auto [Q, V, G] = with_joints_in_equilibrium(sticking, slips, muscles);
  const Index count = G.rows();
  Matrix6d moved = C * R;
  bool is_solved = true;
  if (count > 0) {
    const MatrixXd M = G - V * C * Q;
    LcpWorkspace work(count);
    VectorXd slid(count);
    for (int axis = 0; axis < 6; ++axis) {
      const Vector6d sticks = C * R.col(axis);
      for (const double way : {1.0, -1.0}) {
        const VectorXd w = way * V * sticks;
        if (solve_lcp({M, w}, usual_pivot_budget(count), work, slid).status != LcpStatus::kSolved) {
          is_solved = false;
          continue;
        }
        moved.col(axis) -= 0.5 * way * (C * (Q * slid));
      }
    }
  }
  return {R.transpose() * moved, is_solved};
}

}  // namespace thenar
