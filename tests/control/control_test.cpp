// SPDX-License-Identifier: Apache-2.0
#include "engine/control/control.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "engine/models/build_model.h"
#include "engine/scenes/config.h"
#include "tests/support/algebra.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::control_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Isometry3d pose_of(const Vector3d& p, const Matrix3d& R) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = p;
  X.linear() = R;
  return X;
}

// The error is the twist that takes the object to its target: its position by a difference, its axes by a rotation
// vector in world axes. Rounding of a rotation matrix to an angle: 1e-15 rad; near 90 degrees a few times that.
TEST(PoseError, IsTheMotionToTheTarget) {
  std::mt19937_64 random(4);
  for (const double angle : {0.0, 1e-9, 1e-6, 0.01, std::numbers::pi / 2.0, 3.0}) {
    SCOPED_TRACE(angle);
    const Vector3d axis = random_direction(random), p(0.1, -0.2, 0.3), off(1e-3, 2e-3, -3e-3);
    const Isometry3d object = pose_of(p, random_rotation(random));
    const Isometry3d target = pose_of(p + off, Eigen::AngleAxisd(angle, axis) * object.linear());
    const Vector6d error = pose_error(target, object);
    EXPECT_LE((error.head<3>() - off).norm(), 1e-16);
    EXPECT_LE((error.tail<3>() - angle * axis).norm(), 1e-14);
    // Seen from the target the same motion goes back.
    EXPECT_LE((pose_error(object, target) + error).norm(), 1e-14);
  }
}

// p e + i sum(e T) + d (e - e_last) / T, position and rotation each with their gains; nothing to differentiate at
// first.
// In a hold no share of the error acts: integrals wait, and when it ends the rate of an error that has not moved is
// zero, not its size over a period.
TEST(PosePid, WaitsWhileNothingActs) {
  PosePid pid({300.0, 900.0, 5.0}, {0.5, 1.5, 0.01});
  Vector6d error;
  error << 1e-3, -2e-3, 3e-3, 0.1, 0.2, -0.3;
  constexpr double period_s = 5e-3;
  const Vector6d before = pid.update(error, period_s);
  for (int i = 0; i < 100; ++i) pid.update(error, period_s, 0.0);
  Vector6d integral_step;
  integral_step << 900.0 * period_s * error.head<3>(), 1.5 * period_s * error.tail<3>();
  EXPECT_LE((pid.update(error, period_s) - before - integral_step).norm(), 1e-14);
}

TEST(PosePid, SumsProportionIntegralAndDifference) {
  PosePid pid({300.0, 900.0, 5.0}, {0.5, 1.5, 0.01});
  Vector6d e1, e2;
  e1 << 1e-3, 2e-3, 3e-3, 0.01, 0.02, 0.03;
  e2 << 2e-3, 0.0, 1e-3, 0.0, -0.01, 0.05;
  const double T = 2e-3;
  const Vector6d w1 = pid.update(e1, T), w2 = pid.update(e2, T);
  for (int i = 0; i < 6; ++i) {
    SCOPED_TRACE(i);
    const double p = i < 3 ? 300.0 : 0.5, integral = i < 3 ? 900.0 : 1.5, d = i < 3 ? 5.0 : 0.01;
    EXPECT_NEAR(w1[i], p * e1[i] + integral * T * e1[i], 1e-14);
    EXPECT_NEAR(w2[i], p * e2[i] + integral * T * (e1[i] + e2[i]) + d * (e2[i] - e1[i]) / T, 1e-14);
  }
}

// K y is a joint torque, and moves a joint by K y T / b in a period: 2 b / T is where that overshoots for ever.
TEST(ForceGain, IsAThirdOfTheStabilityBoundOrTheScenes) {
  const Scene fast = scene_of("box_grasp", {"time.control_period=1 ms"});
  const Scene slow = scene_of("box_grasp", {"time.control_period=5 ms"});
  EXPECT_NEAR(force_gain(fast, 0), 0.3 * 2.0 * 0.05 / 1e-3, 1e-12);
  EXPECT_NEAR(force_gain(slow, 0), 0.3 * 2.0 * 0.05 / 5e-3, 1e-12);
  EXPECT_EQ(force_gain(scene_of("box_grasp", {"control.gain=1.5 N*m/rad"}), 0), 1.5);
}

class GraspControl : public testing::Test {
 protected:
  explicit GraspControl(const std::vector<std::string>& overrides = {"object.points=2000"})
      : model(build_model(scene_of("box_grasp", overrides))), state(model) {
    forward_kinematics(model.scene.hand, state.q, pose);
    for (int k = 0; k < kFingers; ++k) contacts[k] = finger_contact(model, pose, state, k);
    std::mt19937_64 random(5);
    for (int k = 0; k < kFingers; ++k) f_desired.col(k) = contacts[k].axes.col(0) + 0.3 * random_direction(random);
  }
  Model model;
  State state;
  HandPose pose;
  PerFinger<GraspContact> contacts{kFingers};
  FingerForces f_desired{3, kFingers};
};

class PaperControl : public GraspControl {
 protected:
  PaperControl() : GraspControl({"object.points=2000", "control.law=paper", "control.gain=20 N*m/rad"}) {}
};

// K_n y_n + nu_n dy_n/dt = e with nu = tau_r K, implicit in a period T: a constant error gives
// y_k = e / K (1 - (1 + T / tau_r)^-k), each direction by its stiffness. Rounding of 20 products.
TEST_F(GraspControl, FilterLagsByTheRelaxationTime) {
  const double tau = model.scene.fingertips->material.relaxation_s;
  const ControlSettings& control = *model.scene.control;
  for (const double T : {0.2e-3, 1e-3, 5e-3}) {
    SCOPED_TRACE(T);
    ForceFilter filter(model);
    FingerForces y;
    for (int step = 1; step <= 20; ++step) {
      y = filter.update(contacts, f_desired, T);
      const double risen = 1.0 - std::pow(1.0 / (1.0 + T / tau), step);
      for (int k = 0; k < kFingers; ++k) {
        const Vector3d n = contacts[k].axes.col(0), f_n = f_desired.col(k).dot(n) * n;
        const Vector3d expected =
            risen * (f_n / control.pulp_normal_N_per_m + (f_desired.col(k) - f_n) / control.pulp_tangential_N_per_m);
        EXPECT_LE((y.col(k) - expected).norm(), 1e-13 * expected.norm());
      }
    }
  }
}

// A finger that does not touch acts with the point of its pulp sphere that looks along the object's nearest inward
// normal. At the start of the box grasp these are faces: the thumb's opposite to the index's and the major's.
TEST_F(GraspControl, UnloadedFingerActsAlongTheNearestNormal) {
  const Matrix3d& R = state.X_WO.linear();
  for (int k = 0; k < kFingers; ++k) {
    SCOPED_TRACE(k);
    const Fingertip& tip = model.scene.hand.fingertips[k];
    const Vector3d centre = pose.distal(model.scene.hand, k) * tip.centre_m, n = contacts[k].axes.col(0);
    // The faces of a box are planes, and their samples lie in them.
    EXPECT_LE((n - (k == 0 ? R.col(0) : Vector3d(-R.col(0)))).norm(), 1e-12);
    EXPECT_LE((contacts[k].point_m - (centre + tip.radius_m * n)).norm(), 1e-16);
    EXPECT_LE((contacts[k].axes.transpose() * contacts[k].axes - Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_GT(contacts[k].axes.determinant(), 0.0);
  }
}

TEST_F(GraspControl, LoadedFingerActsAtItsPressureCentre) {
  FingerLoad& load = state.load[1];
  load = {Vector3d(0.0, 0.0, 1.0), 1.0, Vector3d(0.1, 0.2, 0.3), Vector3d(0.6, 0.0, 0.8)};
  const GraspContact contact = finger_contact(model, pose, state, 1);
  EXPECT_EQ(contact.point_m, load.centre_m);
  EXPECT_LE((contact.axes.col(0) - load.normal).norm(), 1e-15);
}

// Feed-forward: with the forces as desired (y = 0) the joints are at rest, b qdot = tau - g - J' f = 0.
TEST_F(GraspControl, FeedforwardHoldsTheDesiredForces) {
  JointVector net = desired_torques(model, model.scene.posture, pose, model.scene.gravity, contacts, f_desired,
                                    FingerForces::Zero(3, kFingers)) -
                    gravity_torques(model.scene.hand, pose, model.scene.gravity);
  const double scale = net.norm();
  for (int k = 0; k < kFingers; ++k) {
    net.segment<kJointsPerFinger>(kJointsPerFinger * k) -=
        finger_jacobian(model.scene.hand, pose, k, contacts[k].point_m).transpose() * f_desired.col(k);
  }
  EXPECT_LE(net.norm(), 1e-14 * scale);
}

// The torques for a deviation y do what they are for: J tau = K J J^+ y = K y.
TEST_F(PaperControl, TorquesAreTheGainTimesTheDeviation) {
  const JointVector tau =
      desired_torques(model, model.scene.posture, pose, model.scene.gravity, contacts, f_desired, 1e-3 * f_desired);
  for (int k = 0; k < kFingers; ++k) {
    const Vector3d pulled = finger_jacobian(model.scene.hand, pose, k, contacts[k].point_m) *
                            tau.segment<kJointsPerFinger>(kJointsPerFinger * k);
    EXPECT_LE((pulled - 20.0 * 1e-3 * f_desired.col(k)).norm(), 1e-12 * pulled.norm());
  }
}

// A posture torque is the part of a spring that is felt at no fingertip force and moves no fingertip: of J's 4 joints
// the one direction that its 3 rows leave. What it leaves out, the fingertip decides.
TEST_F(GraspControl, PostureTorquesActWhereTheFingertipLeavesTheJointsFree) {
  std::mt19937_64 random(7);
  for (int trial = 0; trial < 100; ++trial) {
    JointVector q = model.scene.posture;
    for (double& angle : q) angle += uniform(random, -0.3, 0.3);
    HandPose here;
    forward_kinematics(model.scene.hand, q, here);
    const JointVector error = model.scene.posture - q;
    for (int k = 0; k < kFingers; ++k) {
      const FingerJacobian J = finger_jacobian(model.scene.hand, here, k, contacts[k].point_m);
      const Eigen::Vector4d e = error.segment<kJointsPerFinger>(kJointsPerFinger * k);
      const Eigen::Vector4d tau = posture_torques(J, 4, 0.5, e);
      EXPECT_LE((J * tau).norm(), 1e-14 * J.norm() * e.norm());
      const Eigen::Matrix4d onto = Eigen::Matrix4d::Identity() - pseudo_inverse(J) * J;
      EXPECT_LE((tau - 0.5 * onto * e).norm(), 1e-10 * e.norm());
    }
  }
}

// Where J is singular there are several such directions, and no torque rather than one of no size that is known.
TEST_F(GraspControl, PostureTorquesVanishWhereTheJacobianIsSingular) {
  FingerJacobian J = finger_jacobian(model.scene.hand, pose, 0, contacts[0].point_m);
  J.row(2) = 2.0 * J.row(0) - J.row(1);
  EXPECT_TRUE(posture_torques(J, 4, 0.5, Eigen::Vector4d::Ones()).isZero(0.0));
  EXPECT_TRUE(posture_torques(FingerJacobian::Zero(3, 4), 4, 0.5, Eigen::Vector4d::Ones()).isZero(0.0));
  J.conservativeResize(3, 5);
  J.col(4) = J.col(0);
  EXPECT_TRUE(posture_torques(J, 5, 0.5, FingerVector::Ones(5)).isZero(0.0));
}

// Five joints leave two directions free, three and fewer none. The projector is that of the pseudo-inverse; minors of
// minors lose a few digits more.
TEST(Posture, HasADirectionForEachJointMoreThanThree) {
  std::mt19937_64 random(8);
  for (int trial = 0; trial < 100; ++trial) {
    SCOPED_TRACE(trial);
    FingerJacobian J = FingerJacobian::Zero(3, 5);
    for (double& x : J.reshaped()) x = uniform(random, -0.1, 0.1);
    FingerVector e(5);
    for (double& x : e) x = uniform(random, -1.0, 1.0);
    const FingerVector tau = posture_torques(J, 5, 0.5, e);
    const Eigen::MatrixXd onto = Eigen::MatrixXd::Identity(5, 5) - pseudo_inverse(J) * J;
    EXPECT_LE((tau - 0.5 * onto * e).norm(), 1e-8 * e.norm());
    FingerJacobian three = J.leftCols(4);
    three.col(3).setZero();
    EXPECT_TRUE(posture_torques(three, 3, 0.5, e.head(4)).isZero(0.0));
  }
}

TEST(Posture, IsNamedInTheSceneWithItsUnit) {
  EXPECT_EQ(scene_of("box_grasp").control->posture_Nm_per_rad, 0.5);
  EXPECT_FALSE(scene_of("minimal").control->posture_Nm_per_rad);
  EXPECT_EQ(scene_of("minimal", {"control.posture=1 N*m/rad"}).control->posture_Nm_per_rad, 1.0);
  for (const char* bad : {"0.5", "0.5 N/m", "0 N*m/rad", "-1 N*m/rad"}) {
    EXPECT_THROW(scene_of("minimal", {std::string("control.posture=") + bad}), ConfigError) << bad;
  }
}

// At rest nothing but the posture torques keeps the joints where the fingertips leave them free: without them a moment
// in the patches turns the fingers, and the muscles go along. The object rests from 2 s on.
TEST(Posture, IsKeptAtRest) {
  const auto drift_rad = [](Scene scene) {
    Loop loop(std::move(scene));
    loop.run(2.0);
    const JointVector before = loop.state.q;
    loop.run(20.0);
    return (loop.state.q - before).cwiseAbs().maxCoeff();
  };
  Scene scene = scene_of("box_grasp", {kCoarseBox, "contact.level=2"});
  EXPECT_LT(drift_rad(scene), std::numbers::pi / 180.0);
  scene.control->posture_Nm_per_rad.reset();
  EXPECT_GT(drift_rad(scene), std::numbers::pi / 180.0) << "else the test shows nothing";
}

// The paper's law at rest: forces f for which the torques it asks for, once the filter has settled, carry just J' f.
// Solved here from the controller's own functions, which are linear in f: tau(f) = tau(0) + T f by trying every unit
// force.
TEST_F(PaperControl, PredictedErrorIsThatOfTheStaticSolution) {
  const auto torques = [&](const FingerForces& f) {
    ForceFilter filter(model);
    const FingerForces y = filter.update(contacts, f_desired - f, 1e12);  // a period in which any lag settles
    return desired_torques(model, model.scene.posture, pose, model.scene.gravity, contacts, f_desired, y);
  };
  const JointVector at_rest = torques(FingerForces::Zero(3, kFingers));
  double sum = 0.0;
  for (int k = 0; k < kFingers; ++k) {
    const auto joints = [&](const JointVector& tau) { return tau.segment<kJointsPerFinger>(kJointsPerFinger * k); };
    Eigen::Matrix<double, kJointsPerFinger, 3> carried =
        finger_jacobian(model.scene.hand, pose, k, contacts[k].point_m).transpose();
    for (int axis = 0; axis < 3; ++axis) {
      FingerForces unit = FingerForces::Zero(3, kFingers);
      unit(axis, k) = 1.0;
      carried.col(axis) -= joints(torques(unit) - at_rest);
    }
    const Eigen::Vector4d tau = joints(at_rest);
    const Vector3d f = least_squares(carried, tau);
    // Four joints carry three force components exactly: the law asks for nothing outside J'.
    EXPECT_LE((carried * f - tau).norm(), 1e-12 * tau.norm());
    sum += (f_desired.col(k) - f).norm() / f_desired.col(k).norm();
  }
  EXPECT_NEAR(predicted_paper_law_error(model, pose, contacts, f_desired), sum / kFingers, 1e-10);
  EXPECT_GT(sum / kFingers, 0.05);
}

}  // namespace
}  // namespace thenar::control_test
