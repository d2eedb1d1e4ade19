#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "engine/control_tick.h"
#include "tests/scenes.h"

namespace thenar {
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

// Without muscles the same torques drive the joints: H f_m = tau^d holds exactly, so muscles do not change the motion.
TEST_F(ControlTick, MusclesDoNotChangeTheDrive) {
  Loop direct(scene_of("box_grasp", {kCoarseBox, "control.muscles=false"}));
  direct.run(50e-3);
  // 50 ticks of torques that differ by the LCP's rounding.
  EXPECT_LE((direct.state.q - loop.state.q).norm(), 1e-9);
  EXPECT_LE((direct.frame.torque_Nm - loop.frame.torque_Nm).norm(), 1e-9);
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
  scene.torques = JointVector::LinSpaced(-0.01, 0.02);
  Loop passive(std::move(scene));
  passive.control();
  HandPose pose;
  forward_kinematics(model.scene.hand, model.scene.posture, pose);
  const JointVector g = gravity_torques(model.scene.hand, pose, model.scene.gravity);
  EXPECT_LE((passive.frame.torque_Nm - (JointVector::LinSpaced(-0.01, 0.02) - g)).norm(), 1e-16);
}

// Frames are numbered, and know the tick of their snapshot.
TEST_F(ControlTick, FramesAreNumberedAndDated) {
  const auto sequence = loop.frame.sequence;
  loop.control();
  EXPECT_EQ(loop.frame.sequence, sequence + 1);
}

}  // namespace
}  // namespace thenar
