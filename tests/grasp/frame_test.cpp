#include "engine/grasp/frame.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>

#include "engine/grasp/delassus.h"
#include "tests/support/algebra.h"
#include "tests/support/scenes.h"

namespace thenar::frame_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kSpeeds = kJoints + 6;  ///< Joints, object's velocity, object's angular velocity.

/// J_c of all the frame's contacts for all speeds.
MatrixXd dense(const Frame& frame, const ContactKinematics& now) {
  MatrixXd J = MatrixXd::Zero(3 * frame.size(), kSpeeds);
  for (Index i = 0; i < frame.size(); ++i) {
    const int first = kJointsPerFinger * frame.contacts[i].finger;
    J.block<3, kJointsPerFinger>(3 * i, first) = now.J_finger.middleRows<3>(3 * i);
    J.block<3, 6>(3 * i, kJoints) = now.J_object.middleRows<3>(3 * i).leftCols<6>();
  }
  return J;
}

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

/// The box grasp at work, 20 ms after its start: three fingers pressed against the box.
class GraspFrame : public testing::Test {
 protected:
  GraspFrame() : loop(scene_of("box_grasp", {kCoarseBox})) {
    loop.run(20e-3);
    loop.control();
    forward_kinematics(model.scene.hand, loop.state.q, pose);
    contact_kinematics(model, frame, pose, loop.state, now);
  }
  Loop loop;
  const Model& model = loop.model;
  const Frame& frame = loop.frame;
  HandPose pose;
  ContactKinematics now{model};
};

TEST_F(GraspFrame, HoldsContactsOfEveryFingerInOrder) {
  ASSERT_GT(frame.size(), 30);
  EXPECT_EQ(frame.begin[0], 0);
  EXPECT_EQ(frame.begin[kFingers], frame.size());
  for (int k = 0; k < kFingers; ++k) {
    EXPECT_GT(frame.begin[k + 1], frame.begin[k]);
    EXPECT_LE(frame.begin[k + 1] - frame.begin[k], model.scene.contact.max_per_finger);
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      EXPECT_EQ(frame.contacts[i].finger, k);
      if (i == frame.begin[k]) continue;
      EXPECT_LT(frame.contacts[i - 1].control_point, frame.contacts[i].control_point);
    }
  }
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

// A contact keeps its gap where the object rolls or slides under it, if its surface is the sphere that the frame took
// it for; a frozen plane would lose t^2 / 2R of it.
TEST(ContactGap, FollowsTheLocalSphere) {
  std::mt19937_64 random(4);
  for (const double R : {0.02, 0.1, -0.05}) {  // convex, and the inside of a ball
    const Vector3d n = random_direction(random), centre(0.3, -0.2, 0.5);
    const FrameContact contact{0, 0, centre - (R + 1e-4) * n, centre - R * n, n, 1.0 / R, Matrix3d::Identity()};
    for (int trial = 0; trial < 20; ++trial) {
      Isometry3d X_FO = random_rotation_about(centre, random);
      X_FO.pretranslate(2e-3 * random_direction(random));
      const double outside_m = (contact.p_F - X_FO * centre).norm() - std::abs(R);
      const auto [gap_m, n_F] = contact_gap(contact, X_FO, Vector3d::Zero());
      EXPECT_NEAR(gap_m, R > 0.0 ? outside_m : -outside_m, 1e-15);
      const Vector3d inwards = std::copysign(1.0, R) * (X_FO * centre - contact.p_F).normalized();
      EXPECT_LE((n_F - inwards).norm(), 1e-13);
    }
  }
}

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

// Tangents are fixed in the finger and turn with the normal without a twist: along a great circle from the pulp's mean
// normal the frame turns as the normal does, in any posture. So the components of a force keep their meaning from frame
// to frame.
TEST(ContactFrame, FollowsTheNormalWithoutATwist) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 100; ++trial) {
    SCOPED_TRACE(trial);
    const Matrix3d R_WF = random_rotation(random);
    const Vector3d mean_F = random_direction(random);
    const Vector3d axis_F = mean_F.cross(random_direction(random)).normalized();
    const Eigen::AngleAxisd turn_F(uniform(random, 0.0, 2.5), axis_F);
    const Matrix3d at_rest = contact_frame(Matrix3d::Identity(), mean_F, mean_F);
    EXPECT_LE((at_rest.col(0) - mean_F).norm(), 1e-15);
    const Matrix3d E_W = contact_frame(R_WF, mean_F, R_WF * (turn_F * mean_F));
    EXPECT_LE((E_W - R_WF * turn_F.toRotationMatrix() * at_rest).norm(), 1e-13);
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

// Rigid fingertips: one contact a finger, at the object's nearest point, where the normal meets both bodies.
TEST(PointContact, IsTheNearestPointOfTheTipsSphere) {
  Loop loop(scene_of("minimal"));
  loop.control();
  ASSERT_EQ(loop.frame.size(), kFingers);
  const double R = std::get<SphereShape>(loop.model.scene.object.shape).radius_m;
  for (int k = 0; k < kFingers; ++k) {
    SCOPED_TRACE(k);
    const FrameContact& contact = loop.frame.contacts[k];
    const Fingertip& tip = loop.model.scene.hand.fingertips[k];
    const Vector3d centre_O =
        loop.state.X_WO.inverse() * (loop.controller.pose.distal(loop.model.scene.hand, k) * tip.centre_m);
    // The ball is sampled: its implicit surface lies within 0.05 mm of it (h^2 / (12 R), h = 2.2 spacings of 1 mm) and
    // its normals within 1 degree.
    EXPECT_NEAR(contact.s_O.norm(), R, 0.05e-3);
    EXPECT_LE(contact.n_O.cross(-centre_O.normalized()).norm(), 0.02);
    EXPECT_GT(contact.n_O.dot(-centre_O), 0.0);
    EXPECT_NEAR((contact.p_F - tip.centre_m).norm(), tip.radius_m, 1e-15);
    EXPECT_LE((contact.p_F - tip.centre_m - tip.radius_m * contact.E_F.col(0)).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace thenar::frame_test
