// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/contact_kinematics.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "engine/grasp/frame.h"
#include "tests/grasp/grasp_frame.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::contact_kinematics_test {
namespace {

using namespace grasp_frame;

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// What a function of the bodies' poses gives when they have moved from a state along one speed: a joint, or the object
/// along or about a world axis.
template <typename Function>
VectorXd moved_along(int speed, double by, const State& state, const Function& function) {
  JointVector q = state.q;
  Isometry3d X_WO = state.X_WO;
  if (speed < kJoints) {
    q[speed] += by;
  } else if (speed < kJoints + 3) {
    X_WO.translation()[speed - kJoints] += by;
  } else {
    X_WO.linear() = Eigen::AngleAxisd(by, Vector3d::Unit(speed - kJoints - 3)) * X_WO.linear();
  }
  return function(q, X_WO);
}

// The contact's axes: a rotation, the first into the object (from a finger towards the box's centre), the same in both
// bodies.
TEST_F(GraspFrame, AxesAreRightHandedAndPointIntoTheObject) {
  for (Index i = 0; i < frame.size(); ++i) {
    const FrameContact& contact = frame.contacts[i];
    const Matrix3d& E = now.E_W[i];
    EXPECT_LE((E.transpose() * E - Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_GT(E.determinant(), 0.0);
    const Matrix3d& R_WF = loop.controller.pose.distal(model.scene.hand, contact.finger).linear();
    EXPECT_LE((R_WF * contact.E_F - E).norm(), 1e-14);
    EXPECT_LE((loop.state.X_WO.linear() * contact.n_O - E.col(0)).norm(), 1e-14);
    EXPECT_GT(contact.n_O.dot(-contact.s_O), 0.0);
  }
}

// J_c maps speeds to the motion of the object against the finger where they meet, c: the derivative, by every joint and
// direction, of the distance between the points of both bodies that are at c now, in the contact's axes of now. Step
// 1e-6: its error is 1e-12 from the curvature (1e-12 times second derivatives below 1) and 1e-17 / 1e-6 from rounding.
TEST_F(GraspFrame, JacobianIsTheRelativeMotionAtTheSurface) {
  constexpr double h = 1e-6;
  const MatrixXd J = dense(frame, now);
  const Hand& hand = model.scene.hand;
  const auto positions = [&](const JointVector& q, const Isometry3d& X_WO) {
    HandPose moved;
    forward_kinematics(hand, q, moved);
    VectorXd all(3 * frame.size());
    for (Index i = 0; i < frame.size(); ++i) {
      const FrameContact& contact = frame.contacts[i];
      const Vector3d c_O = loop.state.X_WO.inverse() * now.c_W[i];
      const Vector3d c_F = pose.distal(hand, contact.finger).inverse() * (loop.state.X_WO * c_O);
      all.segment<3>(3 * i) = now.E_W[i].transpose() * (X_WO * c_O - moved.distal(hand, contact.finger) * c_F);
    }
    return all;
  };
  for (int speed = 0; speed < kSpeeds; ++speed) {
    SCOPED_TRACE(speed);
    const auto moved = [&](double by) { return moved_along(speed, by, loop.state, positions); };
    const VectorXd derivative = (moved(h) - moved(-h)) / (2.0 * h);
    EXPECT_LE((derivative - J.col(speed)).cwiseAbs().maxCoeff(), 1e-10);
  }
}

// J_c's normal rows are the derivative of the gap that a tick computes: only then does contact take no energy from the
// bodies' motion, or give any. On the deformed pulps, whose surface has moved by up to 0.3 mm along the box, so that
// the finger's rest points would not do. Step and tolerance as above.
TEST_F(GraspFrame, JacobianIsTheDerivativeOfTheGap) {
  constexpr double h = 1e-6;
  const MatrixXd J = dense(frame, now);
  const auto gaps = [&](const JointVector& q, const Isometry3d& X_WO) {
    HandPose moved;
    forward_kinematics(model.scene.hand, q, moved);
    VectorXd all(frame.size());
    for (Index i = 0; i < frame.size(); ++i) {
      const FrameContact& contact = frame.contacts[i];
      const Isometry3d X_FO = moved.distal(model.scene.hand, contact.finger).inverse() * X_WO;
      all[i] = contact_gap(contact, X_FO, displacement(loop.state, contact)).gap_m;
    }
    return all;
  };
  for (int speed = 0; speed < kSpeeds; ++speed) {
    SCOPED_TRACE(speed);
    const auto moved = [&](double by) { return moved_along(speed, by, loop.state, gaps); };
    const VectorXd derivative = (moved(h) - moved(-h)) / (2.0 * h);
    for (Index i = 0; i < frame.size(); ++i) EXPECT_NEAR(derivative[i], J(3 * i, speed), 1e-9);
  }
}

// The rotations of hand.yaml have six digits. The contact's axes are orthonormal all the same, and their first is the
// normal, to rounding: the gap and the force must not differ in direction by the file's 1e-6.
TEST(ContactFrame, IsOrthonormalOnAHandOfRoundedRotations) {
  Loop loop(scene_of("box_grasp", {kCoarseBox}));
  loop.run(20e-3);
  loop.control();
  ASSERT_GT(loop.frame.size(), 30);
  ContactKinematics now(loop.model);
  contact_kinematics(loop.model, loop.frame, loop.controller.pose, loop.state, now);
  for (Index i = 0; i < loop.frame.size(); ++i) {
    const Matrix3d& E = now.E_W[i];
    EXPECT_LE((E.transpose() * E - Matrix3d::Identity()).norm(), 1e-14);
    // The normal goes through the rounded rotation and back.
    EXPECT_LE((E.col(0) - loop.state.X_WO.linear() * loop.frame.contacts[i].n_O).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace thenar::contact_kinematics_test
