// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/joint_stops.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "bench/cases/scene_run.h"
#include "engine/grasp/delassus.h"
#include "engine/models/build_model.h"
#include "solvers/contact_newton.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace thenar::joint_stops_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The box grasp with ranges that end `way_rad` beside the posture of its start, on the sides that the seed chooses.
Scene narrow_grasp(unsigned seed, double way_rad) {
  Scene scene =
      scene_of("box_grasp", {kCoarseBox, "contact.level=2", "contact.tolerance=1e-9", "control.muscles=false"});
  std::mt19937_64 random(seed);
  for (Index j = 0; j < scene.posture.size(); ++j) {
    Joint& joint = scene.hand.joints[j];
    (uniform(random, 0.0, 1.0) < 0.5 ? joint.lower_rad : joint.upper_rad) = scene.posture[j];
    const double way = way_rad * uniform(random, 0.0, 1.0);
    joint.lower_rad -= joint.lower_rad == scene.posture[j] ? way : 0.0;
    joint.upper_rad += joint.upper_rad == scene.posture[j] ? way : 0.0;
  }
  return scene;
}

int stopped_in(const TickReport& report) { return static_cast<int>((report.stop_Nm.array() != 0.0).count()); }

// The law of the header, tick by tick, while a grasp carries its box with fingers that meet their stops: a joint is
// never beyond its range by more than the rounding of q, a stop only pushes, and only where the joint rests on it.
TEST(JointStops, PushWhereAJointRestsAndNowhereElse) {
  int stopped = 0, left = 0;
  for (unsigned seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    Loop loop(narrow_grasp(seed, 0.01));
    for (int tick = 0; tick < 700; ++tick) {
      const TickReport report = loop.tick();
      const int before = stopped;
      for (Index j = 0; j < loop.state.q.size(); ++j) {
        const Joint& joint = loop.model.scene.hand.joints[j];
        const double q = loop.state.q[j], stop_Nm = report.stop_Nm[j];
        ASSERT_LE(joint.lower_rad - 1e-15, q);
        ASSERT_LE(q, joint.upper_rad + 1e-15);
        if (stop_Nm == 0.0) continue;
        ++stopped;
        const double at = stop_Nm > 0.0 ? joint.lower_rad : joint.upper_rad;
        // A stop that would pull less than a solve leaves open may hold on.
        if (std::abs(stop_Nm) <= 1e-9) continue;
        ASSERT_NEAR(q, at, 1e-15) << joint.name << " " << stop_Nm;
      }
      if (stopped == before && tick > 0) ++left;
    }
  }
  EXPECT_GT(stopped, 1000);  // or nothing was tested
}

// An independent answer: stops as contacts without friction among those of the fingers, all in one dense problem that
// another method solves. Both are exact to 1e-9 of the forces' scale.
TEST(JointStops, AreThoseOfOneProblemOfContactsAndStops) {
  int compared = 0;
  for (unsigned seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    Loop loop(narrow_grasp(seed, 0.005));
    for (int tick = 0; tick < 400; ++tick) {
      const JointVector q = loop.state.q;
      const TickReport report = loop.tick();
      if (tick % 20 != 0 || stopped_in(report) == 0) continue;
      const Model& model = loop.model;
      const Index n = loop.frame.size(), joints = q.size(), rows = 3 * (n + 2 * joints);
      const Mobility free = mobility(model.scene);
      // Joint j's rows of J: contacts, then its lower and its upper stop.
      MatrixXd J = MatrixXd::Zero(rows, joints);
      for (int k = 0; k < model.fingers(); ++k) {
        const Fingertip& tip = model.scene.hand.fingertips[k];
        const Index first = 3 * loop.frame.begin[k], of_finger = 3 * loop.frame.begin[k + 1] - first;
        J.block(first, tip.first_joint, of_finger, 4) = loop.work.kinematics.J_finger.middleRows(first, of_finger);
      }
      VectorXd delta_free = VectorXd::Zero(rows), mu = VectorXd::Zero(n + 2 * joints);
      mu.head(n) = loop.work.mu.head(n);
      const VectorXd free_dq = free.joint * loop.frame.torque_Nm;
      // What the solver saw, but with the free motion of joints that it knew to be stopped.
      delta_free.head(3 * n) = loop.work.delta_free.head(3 * n);
      for (Index j = 0; j < joints; ++j) {
        const Joint& joint = model.scene.hand.joints[j];
        if (loop.memory.stops.side[j] != 0) {
          const double to_stop = (loop.memory.stops.side[j] > 0 ? joint.upper_rad : joint.lower_rad) - q[j];
          delta_free.head(3 * n) += J.block(0, j, 3 * n, 1) * (free_dq[j] - to_stop);
        }
        const Index lower = 3 * (n + 2 * j), upper = lower + 3;
        J(lower, j) = 1.0;
        J(upper, j) = -1.0;
        delta_free[lower] = q[j] + free_dq[j] - joint.lower_rad;
        delta_free[upper] = joint.upper_rad - q[j] - free_dq[j];
      }
      MatrixXd W = free.joint * J * J.transpose();
      Mobility still = free;
      still.joint = 0.0;
      W.topLeftCorner(3 * n, 3 * n) += dense_delassus(model, loop.frame, loop.work.kinematics, still);
      const ContactData problem{W, delta_free, mu};
      VectorXd f = VectorXd::Zero(rows), delta(rows);
      AccurateWorkspace work(n + 2 * joints);
      const AccurateReport accurate = solve_contacts_accurately(problem, {1e-10}, work, {f, delta});
      ASSERT_EQ(accurate.solve.status, SolveStatus::kConverged);
      for (Index j = 0; j < joints; ++j) {
        const double stop_Nm = f[3 * (n + 2 * j)] - f[3 * (n + 2 * j) + 3];
        EXPECT_NEAR(report.stop_Nm[j], stop_Nm, 1e-7) << model.scene.hand.joints[j].name;
      }
      const double scale_N = f.head(3 * n).cwiseAbs().maxCoeff();
      EXPECT_LE((loop.memory.f.head(3 * n) - f.head(3 * n)).cwiseAbs().maxCoeff(), 1e-5 * scale_N);
      ++compared;
    }
  }
  EXPECT_GT(compared, 30);
}

// Without contact there is one joint and its stop: constant torque, and the joint goes to the end of its range at
// tau / b, stays there while the torque lasts, which the stop bears, and leaves when it turns. The first law holds:
// what the drive still gives when the joint meets its stop is dissipated, and nothing is injected.
TEST(JointStops, BearTheTorqueAndLetGo) {
  Scene scene = scene_of("minimal", {"gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]"});
  scene.control.reset();
  scene.object.X_WO.translation().x() += 1.0;
  scene.torques = scene.hand.at_zero();
  const int j = 6;
  Joint& joint = scene.hand.joints[j];
  joint.upper_rad = scene.posture[j] + 0.0123;
  Loop loop(scene);
  const auto push = [&](double torque_Nm) {
    loop.model.scene.torques = loop.model.scene.hand.at_zero();
    (*loop.model.scene.torques)[j] = torque_Nm;
  };
  const double h = scene.step_s, b = scene.joint_viscosity;
  push(0.02);
  Ledger sum;
  for (int tick = 0; tick < 200; ++tick) {
    const TickReport report = loop.tick();
    sum.add(report.ledger);
    const double way = std::min(0.0123, h / b * 0.02 * (tick + 1));
    EXPECT_NEAR(loop.state.q[j] - scene.posture[j], way, 1e-14 * (tick + 1));
    if (way == 0.0123 && tick > 100) {
      EXPECT_NEAR(report.stop_Nm[j], -0.02, 1e-15);
    }
    EXPECT_EQ(report.ledger.injected_J, 0.0);
    EXPECT_NEAR(report.ledger.drive_J, report.ledger.viscous_J + report.ledger.dissipated_J, 1e-18);
  }
  EXPECT_NEAR(sum.drive_J, 0.02 * 0.0123, 1e-15);
  push(-0.01);
  const double at_end = loop.state.q[j];
  const TickReport report = loop.tick();
  EXPECT_NEAR(loop.state.q[j] - at_end, -h / b * 0.01, 1e-16);
  EXPECT_EQ(report.stop_Nm[j], 0.0);
}

// Ranges that nothing reaches are not there, to the last bit; nor is memory taken where joints meet their stops.
TEST(JointStops, CostNothingWhereNothingReachesThem) {
  Scene scene = scene_of("box_grasp", {kCoarseBox, "contact.level=2"});
  Loop within(scene);
  for (Joint& joint : scene.hand.joints) joint.lower_rad = -10.0, joint.upper_rad = 10.0;
  Loop wide(scene);
  within.run(0.5);
  wide.run(0.5);
  EXPECT_EQ(within.state.q, wide.state.q);
  EXPECT_EQ(within.state.X_WO.matrix(), wide.state.X_WO.matrix());
  Loop stopped(narrow_grasp(1, 0.002));
  stopped.tick();
  int ticks = 0;
  const AllocationCounter counter;
  for (int tick = 0; tick < 300; ++tick) {
    stopped.controller.period_s = scene.control_period_s;
    ticks += stopped_in(contact_tick(stopped.model, stopped.frame, stopped.memory, stopped.work, stopped.state)) > 0;
  }
  EXPECT_EQ(counter.count(), 0);
  EXPECT_GT(ticks, 100);
}

// A viscosity that a finger has of its own: the scene's own value changes no bit, and another one changes W by the
// dense formula h J B^-1 J', B its diagonal.
TEST(JointStops, FingersMayHaveViscositiesOfTheirOwn) {
  Scene scene = scene_of("box_grasp", {kCoarseBox, "contact.level=2"});
  Loop plain(scene);
  for (Fingertip& tip : scene.hand.fingertips) tip.joint_viscosity = scene.joint_viscosity;
  Loop named(scene);
  plain.run(0.3);
  named.run(0.3);
  EXPECT_EQ(plain.state.q, named.state.q);
  EXPECT_EQ(plain.state.X_WO.matrix(), named.state.X_WO.matrix());

  scene.hand.fingertips[1].joint_viscosity = 0.21;
  Loop own(scene);
  for (int tick = 0; tick < 100; ++tick) {
    const TickReport report = own.tick();
    EXPECT_NEAR(report.ledger.drive_J + report.ledger.injected_J,
                report.ledger.viscous_J + report.ledger.deformation_J + report.ledger.dissipated_J, 1e-12);
  }
  const Index n = own.frame.size();
  set_shares(own.model, own.frame, mobility(own.model.scene), own.work.kinematics);
  const MatrixXd W = dense_delassus(own.model, own.frame, own.work.kinematics, mobility(own.model.scene));
  Mobility still = mobility(own.model.scene);
  still.joint = 0.0;
  still.root.resize(0);
  MatrixXd expected = dense_delassus(own.model, own.frame, own.work.kinematics, still);
  for (int k = 0; k < own.model.fingers(); ++k) {
    const Index first = 3 * own.frame.begin[k], rows = 3 * own.frame.begin[k + 1] - first;
    const auto J = own.work.kinematics.J_finger.middleRows(first, rows);
    expected.block(first, first, rows, rows) += scene.step_s / (k == 1 ? 0.21 : 0.05) * J * J.transpose();
  }
  EXPECT_EQ(expected.rows(), 3 * n);
  EXPECT_LE((W - expected).cwiseAbs().maxCoeff(), 1e-14 * W.cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace thenar::joint_stops_test
