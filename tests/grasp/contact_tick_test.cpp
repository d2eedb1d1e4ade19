// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/contact_tick.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "tests/grasp/moving_grasp.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::contact_tick_test {
namespace {

using namespace moving_grasp;

using Eigen::Index;
using Eigen::Vector3d;

/// B^-1 h times what drives the bodies, taken from a frame and from forces in world axes at the contacts: fingers are
/// pushed by -J' f, the object by f and r x f.
struct Motion {
  JointVector dq;
  Vector3d dp, turn;
};
Motion motion_of(const Model& model, const Frame& frame, const ContactKinematics& now, const State& before,
                 const std::vector<ContactForce>& forces) {
  HandPose pose;
  forward_kinematics(model.scene.hand, before.q, pose);
  JointVector torque = frame.torque_Nm;
  Vector3d force = frame.wrench.head<3>(), moment = frame.wrench.tail<3>();
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const FrameContact& contact = frame.contacts[i];
    const Vector3d f = now.E_W[i] * forces[i].f_C, s = now.c_W[i];
    force += f;
    moment += (s - before.X_WO.translation()).cross(f);
    torque.segment<kJointsPerFinger>(kJointsPerFinger * contact.finger) -=
        finger_jacobian(model.scene.hand, pose, contact.finger, s).transpose() * f;
  }
  const double h = model.scene.step_s;
  return {h / model.scene.joint_viscosity * torque, h / model.scene.object.translation_damping * force,
          h / model.scene.object.rotation_damping * moment};
}

// Where the last two ticks changed the forces alike, the next solve starts from as much again, which saves sweeps. It
// changes no result: at a tolerance of 1e-11 the object is carried along the same path, to the 2e-10 m of sums of 300
// ticks' residuals.
TEST(ContactTick, ForcesThatChangeEvenlyAreForeseen) {
  const Model model =
      build_model(scene_of("box_grasp", {kCoarseBox, "contact.tolerance=1e-11", "contact.max_sweeps=1000"}));
  GraspRun foreseeing(model), not_foreseeing(model);
  int sweeps = 0, plain_sweeps = 0;
  while (foreseeing.time_s() < 0.8) {
    not_foreseeing.memory.change_N.setZero();
    const TickReport report = foreseeing.tick(), plain = not_foreseeing.tick();
    ASSERT_EQ(report.solve.status, SolveStatus::kConverged);
    if (foreseeing.time_s() < 0.5) continue;
    sweeps += report.solve.sweeps;
    plain_sweeps += plain.solve.sweeps;
  }
  EXPECT_LE((foreseeing.state.X_WO.translation() - not_foreseeing.state.X_WO.translation()).norm(), 2e-10);
  EXPECT_LE(sweeps, 0.8 * plain_sweeps);
}

// Action = reaction: the bodies move by what their own drive and one set of forces, f on the object and -f on the
// fingers at the same points, give them; and what is reported as a finger's load is the sum of its forces. At a frame's
// first tick, where the frozen geometry is that of the state. Rounding of sums over 60 contacts.
TEST_F(MovingGrasp, ActionIsReaction) {
  for (int tick = 0; tick < 100; ++tick) {
    SCOPED_TRACE(tick);
    const State before = loop.state;
    loop.tick();
    const Motion motion = motion_of(model, loop.frame, loop.work.kinematics, before, loop.state.forces);
    EXPECT_LE((loop.state.q - before.q - motion.dq).norm(), 1e-14);
    EXPECT_LE((loop.state.X_WO.translation() - before.X_WO.translation() - motion.dp).norm(), 1e-15);
    const Eigen::AngleAxisd turn(loop.state.X_WO.linear() * before.X_WO.linear().transpose());
    EXPECT_LE((turn.angle() * turn.axis() - motion.turn).norm(), 1e-14);

    std::array<Vector3d, kFingers> load;
    load.fill(Vector3d::Zero());
    for (std::size_t i = 0; i < loop.state.forces.size(); ++i) {
      load[loop.state.forces[i].finger] += loop.work.kinematics.E_W[i] * loop.state.forces[i].f_C;
    }
    for (int k = 0; k < kFingers; ++k) EXPECT_LE((loop.state.load[k].force_N - load[k]).norm(), 1e-14);
  }
}

// Coulomb's cone holds at every contact of every tick, also where the solver has run out of sweeps. The scaling back to
// the cone rounds once.
TEST_F(MovingGrasp, ForcesStayInTheirCones) {
  loop.model.scene.contact.max_sweeps = 2;
  const double mu = model.scene.contact.friction;
  int loaded = 0;
  while (loop.state.tick < 100) {
    loop.tick();
    for (const ContactForce& force : loop.state.forces) {
      EXPECT_GE(force.f_C[0], 0.0);
      EXPECT_LE(force.f_C.tail<2>().norm(), mu * force.f_C[0] * (1.0 + 1e-15));
      loaded += force.f_C[0] > 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(loaded, 1000);
}

TEST_F(MovingGrasp, DoesNotAllocateAfterTheFirstTick) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours to count";
  loop.tick();
  std::int64_t allocations = 0;
  while (loop.state.tick < 200) {
    loop.control();
    const AllocationCounter counter;
    contact_tick(model, loop.frame, loop.memory, loop.work, loop.state);
    allocations += counter.count();
  }
  EXPECT_EQ(allocations, 0);
}

// Without contacts the bodies drift as their drive and their viscosity say, and nothing divides by a count of zero.
TEST_F(MovingGrasp, MovesFreelyWithoutContacts) {
  Frame frame(model);
  frame.sequence = 7;
  frame.torque_Nm.setConstant(0.01);
  frame.wrench << 1.0, 2.0, 3.0, 0.0, 0.0, 0.0;
  const State before = loop.state;
  const TickReport report = contact_tick(model, frame, loop.memory, loop.work, loop.state);
  EXPECT_EQ(report.contacts, 0);
  EXPECT_EQ(report.solve.status, SolveStatus::kConverged);
  EXPECT_TRUE(is_finite(loop.state));
  EXPECT_TRUE(loop.state.forces.empty());
  const double h = model.scene.step_s;
  EXPECT_LE((loop.state.q - before.q - JointVector::Constant(kJoints, 0.01 * h / model.scene.joint_viscosity)).norm(),
            1e-16);
  EXPECT_LE((loop.state.X_WO.translation() - before.X_WO.translation() -
             h / model.scene.object.translation_damping * Vector3d(1.0, 2.0, 3.0))
                .norm(),
            1e-16);
}

// An eccentric object that nothing holds turns until its weight hangs below its origin: b_o dtheta/dt = -m g c
// sin(theta), so tan(theta / 2) decays exponentially. The weight turns with the object, however old the frame is.
TEST(FreeObject, EccentricWeightTurnsIt) {
  constexpr double kStart_rad = 2.0, kTime_s = 1.0, kLever_m = 10e-3;
  const auto angle_rad = [&](double period_s) {
    Scene scene = pressed_thumb(0.0, {-1.0, 0.0, 0.0}, 10.0);
    scene.object.rotation_damping = 5e-3;
    scene.control_period_s = period_s;
    const Vector3d down = scene.gravity.normalized(), axis = down.unitOrthogonal();
    const Vector3d lever_W = Eigen::AngleAxisd(kStart_rad, axis) * down;
    scene.object.X_WO.translation() += Vector3d(1.0, 1.0, 1.0);  // out of reach
    scene.object.centre_of_mass_m = kLever_m * (scene.object.X_WO.linear().transpose() * lever_W);
    Loop loop(scene);
    loop.run(kTime_s);
    EXPECT_LE((loop.state.X_WO.translation() - scene.object.X_WO.translation() - kTime_s / 10.0 * down).norm(), 1e-12);
    return std::acos(down.dot(loop.state.X_WO.linear() * scene.object.centre_of_mass_m) / kLever_m);
  };
  constexpr double kRate_Hz = 1.0 * kLever_m / 5e-3, kStep_s = 1e-3;
  const double known_rad = 2.0 * std::atan(std::tan(0.5 * kStart_rad) * std::exp(-kRate_Hz * kTime_s));
  // The step is explicit: it leaves h/2 |theta''| <= h k^2 / 4 a second, which grows by exp(k t) at most.
  const double step_rad = 0.25 * kStep_s * kRate_Hz * kRate_Hz * kTime_s * std::exp(kRate_Hz * kTime_s);
  const double every_step_rad = angle_rad(kStep_s);
  EXPECT_NEAR(every_step_rad, known_rad, step_rad);
  EXPECT_NEAR(angle_rad(0.2), every_step_rad, 1e-12);
}

// Whatever the drive, the state stays finite and the forces in their cones.
TEST_F(MovingGrasp, StaysFiniteUnderHugeForces) {
  loop.run(50e-3);
  for (const double wrench : {1e3, 1e9, -1e9}) {
    SCOPED_TRACE(wrench);
    State state = loop.state;
    Frame frame = loop.frame;
    frame.wrench.setConstant(wrench);
    frame.torque_Nm.setConstant(-1e6);
    const TickReport report = contact_tick(model, frame, loop.memory, loop.work, state);
    EXPECT_NE(report.solve.status, SolveStatus::kNotFinite);
    EXPECT_TRUE(is_finite(state));
    for (const ContactForce& force : state.forces) {
      EXPECT_LE(force.f_C.tail<2>().norm(), model.scene.contact.friction * force.f_C[0] * (1.0 + 1e-15));
    }
  }
}

// The contacts of a tick together put in energy where they start it pressed in: on one frozen frame and with sweeps
// enough, only by the second-order part of a tick's turn, although the box is carried and turned and the pulps creep.
// It falls with the step. Five sweeps are not enough, and the ledger shows it.
TEST(Ledger, OneFrameInjectsWhatATickTurnsUnlessSweepsRunOut) {
  const auto ratio = [](const std::string& step, int sweeps) {
    const Model model =
        build_model(scene_of("stick", {"time.step=" + step, "time.duration=0.6 s", "contact.tolerance=1e-14",
                                       "contact.max_sweeps=" + std::to_string(sweeps)}));
    LockstepSettings settings;
    settings.channel = [](double time_s, Frame&) { return time_s <= 0.15; };
    GraspRun loops(model, settings);
    double injected_J = 0.0, dissipated_J = 0.0;
    for (double time_s = 0.0; time_s < 0.6;) {
      const TickReport report = loops.tick();
      time_s = static_cast<double>(loops.state.tick) * model.scene.step_s;
      if (time_s < 0.16) continue;
      const double work_J = report.ledger.injected_J - report.ledger.dissipated_J;
      (work_J > 0.0 ? injected_J : dissipated_J) += std::abs(work_J);
    }
    EXPECT_GT(dissipated_J, 1e-6);
    return injected_J / dissipated_J;
  };
  const double coarse = ratio("0.25 ms", 60);
  EXPECT_LE(coarse, 1e-3);
  EXPECT_LE(ratio("0.125 ms", 60), 0.6 * coarse);
  EXPECT_GT(ratio("0.25 ms", 2), 5.0 * coarse);
}

/// How deep the deformed control points of each pulp are in the object, by its own formula.
template <typename DepthOf>
std::array<double, kFingers> true_depths_m(const Loop& loop, DepthOf depth_of) {
  HandPose pose;
  forward_kinematics(loop.model.scene.hand, loop.state.q, pose);
  std::array<double, kFingers> deepest_m{};
  for (int k = 0; k < kFingers; ++k) {
    const Eigen::Isometry3d X_OF = loop.state.X_WO.inverse() * pose.distal(loop.model.scene.hand, k);
    const Pulp& pulp = loop.model.pulps[k];
    for (Index c = 0; c < pulp.controls(); ++c) {
      const Vector3d p_F = pulp.control_points_m.col(c) - loop.state.u_m[k].row(c).transpose();
      deepest_m[k] = std::max(deepest_m[k], depth_of(Vector3d(X_OF * p_F)));
    }
  }
  return deepest_m;
}

double depth_in_box_m(const Vector3d& p_O) { return 25e-3 - p_O.cwiseAbs().maxCoeff(); }

// With room for 5 and 10 contacts a finger, points that are no contacts pass millimetres into the box. On a flat face
// the surface strays by less than 10 um.
TEST(Penetration, IsThatOfAllControlPoints) {
  for (const int most : {5, 10, 40}) {
    SCOPED_TRACE(most);
    Loop loop(scene_of("box_grasp", {kCoarseBox, "contact.max_per_finger=" + std::to_string(most)}));
    loop.run(0.15);
    const std::array<double, kFingers> depth_m = true_depths_m(loop, depth_in_box_m);
    const TickReport next = loop.tick();  // It measures at its start what it has no room for.
    for (int k = 0; k < kFingers; ++k) EXPECT_NEAR(next.left_out_m[k], std::max(0.0, depth_m[k]), 10e-6) << k;
    EXPECT_NEAR(next.penetration_m, *std::max_element(depth_m.begin(), depth_m.end()), 10e-6);
    EXPECT_EQ(next.penetration_m > 0.1e-3, most < 40);
  }
}

// Where the object is curved a point is measured against the sphere through the samples near it: to a few um.
TEST(Penetration, IsMeasuredOnCurvedObjects) {
  constexpr double kRadius_m = 25e-3, kDepth_m = 1.5e-3;
  Scene scene = pressed_thumb(kDepth_m, Vector3d::Zero(), 1e9);
  const Vector3d n_W = scene.object.X_WO.linear().col(0);
  scene.object.shape = SphereShape{kRadius_m};
  scene.object.points = 12000;
  scene.object.X_WO.translation() += (kRadius_m - 10e-3) * n_W;  // from the middle of a box of 20 mm
  scene.contact.max_per_finger = 4;
  Loop loop(scene);
  for (int tick = 0; tick < 20; ++tick) loop.tick();
  const double depth_m = true_depths_m(loop, [&](const Vector3d& p_O) { return kRadius_m - p_O.norm(); })[0];
  const TickReport next = loop.tick();
  EXPECT_GT(depth_m, 0.3e-3);
  EXPECT_NEAR(next.left_out_m[0], depth_m, 20e-6);
}

}  // namespace
}  // namespace thenar::contact_tick_test
