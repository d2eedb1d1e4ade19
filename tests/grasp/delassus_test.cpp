// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/delassus.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "engine/grasp/frame.h"
#include "tests/grasp/grasp_frame.h"
#include "tests/support/algebra.h"
#include "tests/support/three_fingers.h"

namespace thenar::delassus_test {
namespace {

using namespace grasp_frame;

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// W(h) = h J_c B^-1 J_c' + (1 - rho) C, computed with full matrices; symmetric and positive semi-definite, as f acts on
// the object and -f on the finger. Tolerances are rounding of sums of 18 terms.
TEST_F(GraspFrame, DelassusOperatorIsTheDenseFormula) {
  for (const double h : {31.25e-6, 1e-3, 5e-3}) {
    SCOPED_TRACE(h);
    Model stepped = model;
    stepped.scene.step_s = h;
    const Index rows = 3 * frame.size();
    MatrixXd W(rows, rows);
    delassus_operator(stepped, frame, now, mobility(stepped.scene)).to_dense(W);

    VectorXd b_inverse(kSpeeds);
    b_inverse << VectorXd::Constant(kJoints, 1.0 / model.scene.joint_viscosity),
        VectorXd::Constant(3, 1.0 / model.scene.object.translation_damping),
        VectorXd::Constant(3, 1.0 / model.scene.object.rotation_damping);
    const MatrixXd J = dense(frame, now);
    MatrixXd expected = h * J * b_inverse.asDiagonal() * J.transpose();
    const double rho = std::exp(-h / model.scene.fingertips->material.relaxation_s);
    for (int k = 0; k < kFingers; ++k) {
      const Pulp& pulp = model.pulps[k];
      for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
        for (Index j = frame.begin[k]; j < frame.begin[k + 1]; ++j) {
          const FrameContact &ci = frame.contacts[i], &cj = frame.contacts[j];
          const double kernel = pulp.kernel(ci.control_point, cj.control_point);
          const double a = pulp.a(ci.control_point, cj.control_point), b = pulp.b(ci.control_point, cj.control_point);
          const Vector3d r_W = frame.X_WF[k].linear() * (ci.p_F - cj.p_F);
          Matrix3d across =
              now.E_W[i].transpose() * (a * Matrix3d::Identity() + b * r_W * r_W.transpose()) * now.E_W[j];
          across.row(0).setZero();
          across.col(0).setZero();
          expected.block<3, 3>(3 * i, 3 * j) += (1.0 - rho) * (kernel * now.E_W[i].transpose() * now.E_W[j] + across);
        }
      }
    }
    const double largest = expected.cwiseAbs().maxCoeff();
    EXPECT_LE((W - expected).cwiseAbs().maxCoeff(), 1e-13 * largest);
    EXPECT_LE((W - W.transpose()).cwiseAbs().maxCoeff(), 1e-15 * largest);
    const double least = eigenvalues(W)[0];
    EXPECT_GE(least, -1e-13 * largest);
  }
}

}  // namespace
}  // namespace thenar::delassus_test
