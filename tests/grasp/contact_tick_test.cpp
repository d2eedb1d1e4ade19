#include "engine/grasp/contact_tick.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace thenar::contact_tick_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

// Kelvin-Voigt: under a constant force the pulp gives way by C f (1 - exp(-t / tau_r)), exactly at every step length.
// One contact without friction, on a box so easy to move (1e-10 N s/m) that its drag takes 1e-10 / (tau_r / C) of the
// force.
TEST(Memory, OneContactCreepsExponentially) {
  for (const double step_s : {0.1e-3, 1e-3, 10e-3}) {
    for (const double tau : {2e-3, 20e-3}) {
      SCOPED_TRACE(testing::Message() << "step " << step_s << ", tau_r " << tau);
      const double force_N = 0.05;
      Scene scene = pressed_thumb(0.0, {-force_N, 0.0, 0.0}, 1e-10);
      scene.step_s = step_s;
      scene.control_period_s = 1.0;  // one frame
      scene.contact.max_per_finger = 1;
      scene.contact.friction = 0.0;
      scene.contact.tolerance = 1e-14;
      scene.fingertips->material.relaxation_s = tau;
      Loop loop(std::move(scene));
      for (int tick = 1; tick <= std::lround(3.0 * tau / step_s) + 1; ++tick) {
        loop.tick();
        ASSERT_EQ(loop.frame.begin[1], 1);  // of the thumb
        const FrameContact& contact = loop.frame.contacts[0];
        const Pulp& pulp = loop.model.pulps[0];
        const double full_m = pulp.kernel(contact.control_point, contact.control_point) * force_N;
        const double u_m = contact.E_F.col(0).dot(loop.state.u_m[0].row(contact.control_point));
        EXPECT_NEAR(u_m / full_m, 1.0 - std::exp(-tick * step_s / tau), 1e-9);
      }
    }
  }
}

/// How far the box has moved along a tangent when the thumb has carried 1 N for 20 tau_r, after `time_s` under half the
/// tangential force that it can hold, tau_r = 20 ms.
double creep_m(double step_s, double time_s) {
  Scene scene = pressed_thumb(1e-3, {-1.0, 0.0, 0.0}, 0.1);
  scene.step_s = step_s;
  scene.control_period_s = step_s;
  scene.contact.friction = 0.8;
  scene.contact.tolerance = 1e-10;
  scene.contact.max_sweeps = 100'000;
  scene.fingertips->material.relaxation_s = 20e-3;
  scene.task.push = Push{{0.0, 0.4, 0.0}, 0.4, 10.0};  // half of mu F_n
  Loop loop(std::move(scene));
  loop.run(0.4);
  const Vector3d before = loop.state.X_WO.translation();
  loop.run(time_s);
  const Vector3d moved = loop.model.scene.object.X_WO.linear().transpose() * (loop.state.X_WO.translation() - before);
  return moved.y();
}

// Case T24: the exponential memory knows no step. What is left is the box's drag (0.1 N s/m against the pulp's 900 N/m:
// 0.1 ms of 20 ms, by implicit Euler), a part of 1e-3. Implicit Euler for the pulp would be 1 % off at 1 ms and 11 % at
// 10 ms.
TEST(Memory, CreepDoesNotDependOnTheStep) {
  const double fine_m = creep_m(0.1e-3, 20e-3);
  EXPECT_GT(fine_m, 100e-6);
  EXPECT_NEAR(creep_m(1e-3, 20e-3) / fine_m, 1.0, 1e-3);
  EXPECT_NEAR(creep_m(10e-3, 20e-3) / fine_m, 1.0, 1e-3);
}

// A contact that sticks under a constant load does not creep once the pulp has settled. The solver leaves 1e-12 of a
// free motion of 1 mm a tick, 5e-12 m in 5000 ticks if all of it points one way; 1e-9 m is a hundredth of a percent of
// the elastic give.
TEST(Memory, StickDoesNotDrift) {
  Scene scene = pressed_thumb(1e-3, {-1.0, 0.4, 0.0}, 1.0);
  scene.step_s = scene.control_period_s = 1e-3;
  scene.contact.tolerance = 1e-12;
  scene.contact.max_sweeps = 100'000;
  Loop loop(std::move(scene));
  loop.run(0.5);
  const Vector3d before = loop.state.X_WO.translation();
  loop.run(5.0);
  EXPECT_LE((loop.state.X_WO.translation() - before).norm(), 1e-9);
}

/// The box grasp, carried sideways from the start on so that everything moves.
class MovingGrasp : public testing::Test {
 protected:
  MovingGrasp() : loop(scene_of("box_grasp", {kCoarseBox, "task.translate.from=0 s", "task.translate.over=100 ms"})) {}
  Loop loop;
  const Model& model = loop.model;
};

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
        finger_jacobian(pose, contact.finger, s).transpose() * f;
  }
  const double h = model.scene.step_s;
  return {h / model.scene.joint_viscosity * torque, h / model.scene.object.translation_damping * force,
          h / model.scene.object.rotation_damping * moment};
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

// The pulp moves by the compliance that the solver had where the tick has a contact; elsewhere by its mean over the
// directions across the normals of the forces. Rounding of sums over 20 contacts.
TEST_F(MovingGrasp, PulpsDeformByOneCompliance) {
  for (int tick = 0; tick < 50; ++tick) {
    SCOPED_TRACE(tick);
    const State before = loop.state;
    loop.tick();
    const Frame& frame = loop.frame;
    const auto& E_F = loop.work.kinematics.E_F;
    for (int k = 0; k < kFingers; ++k) {
      const Pulp& pulp = model.pulps[k];
      const double rho = retained_share(pulp.material, model.scene.step_s);
      const Index begin = frame.begin[k], end = frame.begin[k + 1];
      Eigen::MatrixX3d u = rho * before.u_m[k];
      for (Index c = 0; c < pulp.controls(); ++c) {
        const auto at_c = std::find_if(frame.contacts.begin() + begin, frame.contacts.begin() + end,
                                       [&](const FrameContact& contact) { return contact.control_point == c; });
        const Index i = at_c - frame.contacts.begin();
        for (Index j = begin; j < end; ++j) {
          const Index d = frame.contacts[j].control_point;
          const Vector3d f_C = loop.state.forces[j].f_C;
          const Vector3d mean = E_F[j] * Vector3d(1.0, pulp.tangential, pulp.tangential).cwiseProduct(f_C);
          const Vector3d moved =
              i < end ? Vector3d(E_F[i] * frame.compliance[k].entry(i - begin, j - begin, E_F[i], E_F[j]) * f_C)
                      : Vector3d(pulp.kernel(c, d) * mean);
          u.row(c) += (1.0 - rho) * moved.transpose();
        }
      }
      EXPECT_LE((loop.state.u_m[k] - u).cwiseAbs().maxCoeff(), 1e-15);
    }
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

// A new frame finds the forces of the last tick by finger and control point. A tolerance that any guess meets keeps the
// solver from changing them; contacts without a force of their own start at zero.
TEST_F(MovingGrasp, ForcesAreCarriedToANewFrameById) {
  loop.run(50e-3);
  std::erase_if(loop.state.forces, [](const ContactForce& force) { return force.control_point % 3 == 0; });
  std::erase_if(loop.state.forces, [](const ContactForce& force) { return force.finger == 2; });
  const auto before = loop.state.forces;
  loop.model.scene.contact.tolerance = 1e9;
  loop.control();
  contact_tick(model, loop.frame, loop.work, loop.state);

  ASSERT_EQ(std::ssize(loop.state.forces), loop.frame.size());
  int carried = 0;
  for (Index i = 0; i < loop.frame.size(); ++i) {
    const ContactForce& force = loop.state.forces[i];
    EXPECT_EQ(force.finger, loop.frame.contacts[i].finger);
    EXPECT_EQ(force.control_point, loop.frame.contacts[i].control_point);
    const auto same = std::find_if(before.begin(), before.end(), [&](const ContactForce& old) {
      return old.finger == force.finger && old.control_point == force.control_point;
    });
    const Vector3d expected = same == before.end() ? Vector3d(Vector3d::Zero()) : same->f_C;
    EXPECT_LE((force.f_C - expected).norm(), 1e-15);
    carried += expected[0] > 0.0 ? 1 : 0;
  }
  EXPECT_GT(carried, 5);
}

TEST_F(MovingGrasp, DoesNotAllocateAfterTheFirstTick) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours to count";
  loop.tick();
  std::int64_t allocations = 0;
  while (loop.state.tick < 200) {
    loop.control();
    const AllocationCounter counter;
    contact_tick(model, loop.frame, loop.work, loop.state);
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
  const TickReport report = contact_tick(model, frame, loop.work, loop.state);
  EXPECT_EQ(report.contacts, 0);
  EXPECT_EQ(report.solve.status, SolveStatus::kConverged);
  EXPECT_TRUE(is_finite(loop.state));
  EXPECT_TRUE(loop.state.forces.empty());
  const double h = model.scene.step_s;
  EXPECT_LE((loop.state.q - before.q - JointVector::Constant(0.01 * h / model.scene.joint_viscosity)).norm(), 1e-16);
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
    const TickReport report = contact_tick(model, frame, loop.work, state);
    EXPECT_NE(report.solve.status, SolveStatus::kNotFinite);
    EXPECT_TRUE(is_finite(state));
    for (const ContactForce& force : state.forces) {
      EXPECT_LE(force.f_C.tail<2>().norm(), model.scene.contact.friction * force.f_C[0] * (1.0 + 1e-15));
    }
  }
}

}  // namespace
}  // namespace thenar::contact_tick_test
