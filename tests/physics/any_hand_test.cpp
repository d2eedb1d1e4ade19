// SPDX-License-Identifier: Apache-2.0
// Hands of any size: the laws of a tick, for hands that are made at random.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "engine/grasp/contact_tick.h"
#include "engine/models/build_model.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace thenar::any_hand_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kBall_m = 25e-3, kPulp_m = 8e-3, kDepth_m = 0.5e-3;

/// Up to 5 fingers of up to 5 joints around a ball, their pulps pressed into it by about a newton each.
Scene random_grip(unsigned seed) {
  std::mt19937_64 random(seed);
  const auto count = [&](int most) { return 1 + static_cast<int>(uniform(random, 0.0, 0.999) * most); };
  Scene scene = scene_of("stick");
  scene.task = {};
  scene.gravity.setZero();
  scene.step_s = scene.control_period_s = 1e-3;
  scene.object.shape = SphereShape{kBall_m};
  scene.object.points = 4000;
  scene.object.X_WO.setIdentity();
  scene.contact.tolerance = 1e-11;
  scene.contact.max_sweeps = 2000;
  Hand& hand = scene.hand;
  hand = {};
  Segment palm;
  palm.name = "palm";
  palm.X_WS_0.setIdentity();
  hand.segments.push_back(palm);
  const int fingers = count(kMaxFingers);
  for (int k = 0; k < fingers; ++k) {
    Fingertip tip;
    tip.finger = "finger " + std::to_string(k);
    tip.first_joint = static_cast<int>(hand.joints.size());
    tip.joints = count(kMaxFingerJoints);
    tip.segment = k + 1;
    tip.radius_m = kPulp_m;
    tip.centre_m.setZero();
    tip.normal = Vector3d::UnitY();
    if (k % 2 == 1) tip.joint_viscosity = 0.05 * uniform(random, 0.5, 2.0);
    if (k % 3 == 1) tip.relaxation_s = uniform(random, 0.0, 5e-3);
    // Spread over the ball, so that the sum of all presses is small.
    const double z = fingers > 1 ? -0.6 + 1.2 * k / (fingers - 1) : 0.0, turn = 2.4 * k;
    const Vector3d outward(std::sqrt(1.0 - z * z) * std::cos(turn), std::sqrt(1.0 - z * z) * std::sin(turn), z);
    Segment distal;
    distal.name = "distal " + std::to_string(k);
    distal.finger = k;
    distal.joints = tip.joints;
    distal.X_WS_0 = Eigen::Isometry3d(Eigen::Quaterniond::FromTwoVectors(tip.normal, -outward));
    distal.X_WS_0.translation() = (kBall_m + kPulp_m - kDepth_m) * outward;
    distal.length_m = 20e-3;
    for (int j = 0; j < tip.joints; ++j) {
      const Vector3d origin = distal.X_WS_0.translation() + 0.03 * outward + 0.03 * random_direction(random);
      hand.joints.push_back({"joint", origin, random_direction(random), -1.0, 1.0});
    }
    hand.segments.push_back(distal);
    hand.fingertips.push_back(tip);
  }
  scene.posture = hand.at_zero();
  scene.torques = hand.at_zero();
  for (double& torque : *scene.torques) torque = uniform(random, -0.01, 0.01);
  return scene;
}

/// Free motion of one tick and that by the forces which it found, from the laws of the header: b qd = tau + r - J' f a
/// joint, and f and its moment on the object.
void expect_action_is_reaction(const Loop& loop, const State& before, const TickReport& report) {
  const Model& model = loop.model;
  HandPose pose;
  forward_kinematics(model.scene.hand, before.q, pose);
  JointVector torque = loop.frame.torque_Nm + report.stop_Nm;
  Vector3d force = loop.frame.wrench.head<3>();
  for (std::size_t i = 0; i < loop.state.forces.size(); ++i) {
    const int k = loop.frame.contacts[i].finger;
    const Fingertip& tip = model.scene.hand.fingertips[k];
    const Vector3d f = loop.work.kinematics.E_W[i] * loop.state.forces[i].f_C;
    force += f;
    const FingerJacobian J = finger_jacobian(model.scene.hand, pose, k, loop.work.kinematics.c_W[i]);
    torque.segment(tip.first_joint, tip.joints) -= J.leftCols(tip.joints).transpose() * f;
  }
  for (int k = 0; k < model.fingers(); ++k) {
    const Fingertip& tip = model.scene.hand.fingertips[k];
    const auto own = [&](const JointVector& all) { return all.segment(tip.first_joint, tip.joints); };
    const JointVector moved = loop.state.q - before.q;
    EXPECT_LE((own(moved) - model.scene.step_s / model.scene.viscosity(k) * own(torque)).norm(), 1e-14);
  }
  const Vector3d expected = model.scene.step_s / model.scene.object.translation_damping * force;
  EXPECT_LE((loop.state.X_WO.translation() - before.X_WO.translation() - expected).norm(), 1e-14);
}

class AnyHand : public testing::TestWithParam<unsigned> {};

// Action is reaction and the first law holds, whatever the numbers of fingers and joints; contacts carry force, and no
// memory is taken. The balance is that of sums of some 100 products of about 1e-5 J.
TEST_P(AnyHand, ObeysTheLawsOfATick) {
  Loop loop(random_grip(GetParam()));
  int active = 0;
  for (int tick = 0; tick < 60; ++tick) {
    SCOPED_TRACE(tick);
    const State before = loop.state;
    const TickReport report = loop.tick();
    ASSERT_EQ(report.solve.status, SolveStatus::kConverged);
    active += static_cast<int>(report.active);
    expect_action_is_reaction(loop, before, report);
    const Ledger& e = report.ledger;
    EXPECT_NEAR(e.drive_J - e.viscous_J - e.deformation_J + e.injected_J - e.dissipated_J, 0.0, 1e-12);
  }
  EXPECT_GT(active, 60 * loop.model.fingers());
  if (!AllocationCounter::is_available()) return;
  const AllocationCounter counter;
  for (int tick = 0; tick < 20; ++tick) (void)contact_tick(loop.model, loop.frame, loop.memory, loop.work, loop.state);
  EXPECT_EQ(counter.count(), 0);
}

// A contact's own block of the factors that are solved with is the dense formula W = J_c h B^-1 J_c' + (1 - rho) C, for
// the joints, viscosity and material of its finger. Rounding of sums of 14 products.
TEST_P(AnyHand, MovesByItsDelassusOperator) {
  Loop loop(random_grip(GetParam()));
  loop.run(0.02);
  const Model& model = loop.model;
  HandPose pose;
  forward_kinematics(model.scene.hand, loop.state.q, pose);
  contact_kinematics(model, loop.frame, pose, loop.state, loop.work.kinematics);
  const Mobility own = mobility(model.scene);
  set_shares(model, loop.frame, own, loop.work.kinematics);
  const MatrixXd W = dense_delassus(model, loop.frame, loop.work.kinematics, own);
  const Index n = loop.frame.size();
  ASSERT_GT(n, 0);
  for (Index i = 0; i < n; i += 5) {
    const int k = loop.frame.contacts[i].finger;
    const FingerJacobian J = finger_jacobian(model.scene.hand, pose, k, loop.work.kinematics.c_W[i]);
    const Eigen::Matrix3d E = loop.work.kinematics.E_W[i];
    const Vector3d r = loop.work.kinematics.c_W[i] - loop.state.X_WO.translation();
    Eigen::Matrix3d cross;
    cross << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
    const double h = model.scene.step_s;
    Eigen::Matrix3d W_ii = h / model.scene.viscosity(k) * J * J.transpose() +
                           h / model.scene.object.translation_damping * Eigen::Matrix3d::Identity() -
                           h / model.scene.object.rotation_damping * cross * cross;
    W_ii = E.transpose() * W_ii * E;
    const Pulp& pulp = model.pulps[k];
    const Index c = loop.frame.contacts[i].control_point;
    const double share = 1.0 - retained_share(pulp.material, h);
    W_ii += share * Vector3d(pulp.kernel(c, c), pulp.kernel(c, c) + pulp.a(c, c), pulp.kernel(c, c) + pulp.a(c, c))
                        .asDiagonal()
                        .toDenseMatrix();
    EXPECT_LE((W.block<3, 3>(3 * i, 3 * i) - W_ii).norm(), 1e-13 * W_ii.norm()) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, AnyHand, testing::Range(0U, 12U));

}  // namespace
}  // namespace thenar::any_hand_test
