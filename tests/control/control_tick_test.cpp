// SPDX-License-Identifier: Apache-2.0
#include "engine/control/control_tick.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "engine/models/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::control_tick_test {
namespace {

using Eigen::Vector3d;

/// The box grasp when the grip has built up.
class ControlTick : public testing::Test {
 protected:
  ControlTick() : loop(scene_of("box_grasp", {kCoarseBox})) { loop.run(50e-3); }
  Loop loop;
  const Model& model = loop.model;
};

// The chain of the control period closes: G f^d = W^d (which feeds gravity forward), H f_m = tau^d with f_m >= 0, and
// the frame's drive is tau - g. Tolerances: the LCP counts 1e-11 of the largest entries as zero.
TEST_F(ControlTick, ForcesGiveTheWrenchAndMusclesTheTorques) {
  loop.control();
  const ControlReport& report = loop.report;
  EXPECT_EQ(report.grasp, GraspStatus::kOptimal);
  EXPECT_EQ(report.muscle, MuscleStatus::kOptimal);

  Eigen::MatrixXd G(6, 9);
  grasp_map(report.contacts, loop.state.X_WO.translation(), G);
  EXPECT_LE((G * report.f_desired.reshaped() - report.wrench_desired).norm(), 1e-9);

  EXPECT_GE(loop.controller.f_muscle.minCoeff(), 0.0);
  EXPECT_LE(report.muscle_residual_Nm, 1e-9);
  const JointVector tau = loop.controller.H * loop.controller.f_muscle;
  const JointVector g = gravity_torques(model.scene.hand, loop.controller.pose, model.scene.gravity);
  EXPECT_LE((loop.frame.torque_Nm - (tau - g)).norm(), 1e-15);
}

// A period without pose error asks for what holds the box against its weight, and no more.
TEST_F(ControlTick, GravityIsFedForward) {
  Controller controller(model);
  State state(model);
  const ControlReport report = control_tick(model, state, controller, loop.frame);
  EXPECT_LE((report.wrench_desired.head<3>() + model.scene.object.mass_kg * model.scene.gravity).norm(), 1e-15);
  EXPECT_LE(report.wrench_desired.tail<3>().norm(), 1e-15);
}

// The weight acts at the centre of mass, in the frame and in what is asked of the fingers, in whatever pose.
TEST_F(ControlTick, GravityActsAtTheCentreOfMass) {
  Scene scene = model.scene;
  scene.object.centre_of_mass_m = Vector3d(3e-3, -8e-3, 5e-3);
  const Model eccentric = build_model(scene);
  State state(eccentric);
  state.X_WO.linear() = state.X_WO.linear() * Eigen::AngleAxisd(0.3, Vector3d(1.0, 2.0, -2.0) / 3.0);
  Controller controller(eccentric);
  const ControlReport report = control_tick(eccentric, state, controller, loop.frame);
  const Vector3d force_N = scene.object.mass_kg * scene.gravity;
  const Vector3d moment_Nm = (state.X_WO * scene.object.centre_of_mass_m - state.X_WO.translation()).cross(force_N);
  ASSERT_GT(moment_Nm.norm(), 5e-3);
  EXPECT_LE((loop.frame.wrench.head<3>() - force_N).norm(), 1e-15);
  EXPECT_LE((loop.frame.wrench.tail<3>() - moment_Nm).norm(), 1e-16);
  // Without integrals yet, the PID asks for p times the error.
  const Vector6d error = pose_error(eccentric.target(0.0), state.X_WO);
  const Vector3d D_Nm =
      (scene.control->rotation.p + scene.control_period_s * scene.control->rotation.i) * error.tail<3>();
  EXPECT_LE((report.wrench_desired.tail<3>() - (D_Nm - moment_Nm)).norm(), 1e-15);
}

// Without muscles the same torques drive the joints: H f_m = tau^d holds exactly, so muscles do not change the motion.
TEST_F(ControlTick, MusclesDoNotChangeTheDrive) {
  Loop direct(scene_of("box_grasp", {kCoarseBox, "control.muscles=false"}));
  direct.run(50e-3);
  // 50 ticks of torques that differ by the LCP's rounding, by which a solve may end a sweep sooner or later: residuals
  // of 1e-7 N, which turn joints by 1e-8 rad.
  EXPECT_LE((direct.state.q - loop.state.q).norm(), 2e-8);
  EXPECT_LE((direct.frame.torque_Nm - loop.frame.torque_Nm).norm(), 1e-7);
}

// The push acts on the object in its time, and the controller does not know of it: until it has moved the box, what is
// asked of the fingers is to the last bit what it would be without.
TEST_F(ControlTick, PushIsInTheFrameAndNotInTheDesiredWrench) {
  Scene scene = model.scene;
  scene.task = {};
  Loop quiet(scene);
  scene.task.push = Push{{0.1, 0.5, 0.2}, 2e-3, 3e-3};
  Loop pushed(scene);
  const Vector3d push_N = scene.object.X_WO.linear() * scene.task.push->force_N;
  for (int tick = 0; tick < 8; ++tick) {
    SCOPED_TRACE(tick);
    quiet.tick();
    pushed.tick();
    const bool acts = tick >= 2 && tick < 5;
    const Vector6d added = pushed.frame.wrench - quiet.frame.wrench;
    EXPECT_LE((added.head<3>() - (acts ? push_N : Vector3d(Vector3d::Zero()))).norm(), 1e-15);
    EXPECT_EQ(added.tail<3>(), Vector3d::Zero());
    EXPECT_EQ(pushed.report.wrench_desired == quiet.report.wrench_desired, tick <= 2);
  }
}

// A force at a point of the object is the force at its origin and a moment; a moment is added to it. Both in object
// axes at the start, while the point turns with the object.
TEST_F(ControlTick, PushHasALeverAndAMoment) {
  Scene scene = model.scene;
  const Vector3d force_O(0.1, 0.5, 0.2), at_O(10e-3, -5e-3, 20e-3), moment_O(1e-3, -2e-3, 3e-3);
  scene.task.push = Push{.force_N = force_O, .over_s = 1.0, .at_m = at_O, .moment_Nm = moment_O};
  const Model pushed = build_model(scene);
  const Eigen::Matrix3d& R = scene.object.X_WO.linear();
  const Vector6d there = pushed.external_wrench(0.5, scene.object.X_WO) - pushed.weight(scene.object.X_WO);
  EXPECT_LE((there.head<3>() - R * force_O).norm(), 1e-15);
  EXPECT_LE((there.tail<3>() - R * (at_O.cross(force_O) + moment_O)).norm(), 1e-16);
  EXPECT_EQ(pushed.external_wrench(1.0, scene.object.X_WO), pushed.weight(scene.object.X_WO)) << "it is over";

  Eigen::Isometry3d turned = scene.object.X_WO;
  turned.rotate(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitZ()));  // x goes where y was, y where -x was
  const Vector6d then = pushed.external_wrench(0.5, turned) - pushed.weight(turned);
  const Vector3d at_start(-at_O.y(), at_O.x(), at_O.z());
  EXPECT_LE((then.head<3>() - R * force_O).norm(), 1e-15);
  EXPECT_LE((then.tail<3>() - R * (at_start.cross(force_O) + moment_O)).norm(), 1e-16);
}

// What the controller knows of an eccentric weight it need not learn from an error: the same moment, unknown, turns the
// box by itself over the gain p, until the integral has grown.
TEST_F(ControlTick, AnEccentricWeightDoesNotTurnTheBox) {
  const auto turn_rad = [](Scene scene) {
    scene.task.translate.reset();
    Loop grasp(std::move(scene));
    grasp.run(0.15);  // Integrals take 0.32 s.
    return pose_error(grasp.model.scene.object.X_WO, grasp.state.X_WO).tail<3>().norm();
  };
  Scene known = model.scene, unknown = model.scene;
  known.object.centre_of_mass_m = Vector3d(0.0, 8e-3, 0.0);
  const Vector3d weight_O = known.object.X_WO.linear().transpose() * (known.object.mass_kg * known.gravity);
  const Vector3d moment_O = known.object.centre_of_mass_m.cross(weight_O);
  unknown.task.push = Push{.over_s = 1.0, .moment_Nm = moment_O};
  const double without_rad = turn_rad(unknown);
  EXPECT_GT(without_rad, 0.5 * moment_O.norm() / model.scene.control->rotation.p);
  EXPECT_LT(turn_rad(known), 0.2 * without_rad);
}

// An infeasible problem is a status, and the last forces go on.
TEST_F(ControlTick, InfeasibleGraspKeepsTheLastForces) {
  loop.control();
  const FingerForces before = loop.report.f_desired;
  // Without friction the fingers' normals, all along the grip axis, cannot carry the weight across it.
  loop.model.scene.control->grasp_friction = 0.0;
  loop.control();
  EXPECT_EQ(loop.report.grasp, GraspStatus::kInfeasible);
  EXPECT_EQ(loop.report.f_desired, before);
  EXPECT_TRUE(loop.frame.torque_Nm.allFinite());
}

// A scene without a controller is driven by its torques: tau - g.
TEST_F(ControlTick, GivenTorquesDriveASceneWithoutControl) {
  Scene scene = model.scene;
  scene.control.reset();
  scene.task = {};
  scene.torques = JointVector::LinSpaced(12, -0.01, 0.02);
  Loop passive(std::move(scene));
  passive.control();
  HandPose pose;
  forward_kinematics(model.scene.hand, model.scene.posture, pose);
  const JointVector g = gravity_torques(model.scene.hand, pose, model.scene.gravity);
  EXPECT_LE((passive.frame.torque_Nm - (JointVector::LinSpaced(12, -0.01, 0.02) - g)).norm(), 1e-16);
}

// Frames are numbered, and know the tick of their snapshot.
TEST_F(ControlTick, FramesAreNumberedAndDated) {
  const auto sequence = loop.frame.sequence;
  loop.control();
  EXPECT_EQ(loop.frame.sequence, sequence + 1);
}

}  // namespace
}  // namespace thenar::control_tick_test
