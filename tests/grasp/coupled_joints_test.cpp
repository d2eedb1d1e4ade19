// SPDX-License-Identifier: Apache-2.0
#include "engine/hand/coupled_joints.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "bench/cases/scene_run.h"
#include "engine/control/control.h"
#include "engine/grasp/delassus.h"
#include "engine/hand/muscles.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/coupled_hand.h"
#include "tests/support/scenes.h"

namespace thenar::coupled_joints_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// A hand, the same with couplings, and what these make of its angles: all = S q + q0.
struct Pair {
  Hand full, coupled_one;
  MatrixXd S;
  VectorXd q0;

  Pair(const Hand& hand, const std::vector<Coupling>& couplings) : full(hand), coupled_one(coupled(hand, couplings)) {
    const Index all = std::ssize(full.joints), own = std::ssize(coupled_one.joints);
    MatrixXd of_own = MatrixXd::Zero(all, all);
    q0 = VectorXd::Zero(all);
    std::vector<Index> column(all, -1);
    Index next = 0;
    const auto coupling_of = [&](Index j) {
      return std::find_if(couplings.begin(), couplings.end(), [&](const Coupling& c) { return c.joint == j; });
    };
    for (Index j = 0; j < all; ++j) {
      if (coupling_of(j) == couplings.end()) column[j] = next++;
    }
    S = MatrixXd::Zero(all, own);
    for (Index j = 0; j < all; ++j) {
      const auto c = coupling_of(j);
      S(j, column[c == couplings.end() ? j : c->leader]) = c == couplings.end() ? 1.0 : c->ratio;
      if (c != couplings.end()) q0[j] = c->offset_rad;
    }
  }
  [[nodiscard]] JointVector all(const JointVector& q) const { return S * q + q0; }
};

/// hand.yaml with one joint that follows, two that follow one, and one that turns against its leader.
Pair several() {
  return {scene_of("box_grasp").hand, {{3, 2, 1.3, 0.2}, {5, 4, -0.4, 0.1}, {10, 8, 0.8, 0.0}, {11, 8, 0.6, -0.1}}};
}

JointVector random_q(const Hand& hand, std::mt19937_64& random) {
  JointVector q = hand.at_zero();
  for (Index j = 0; j < q.size(); ++j) q[j] = uniform(random, -1.0, 1.5);
  return q;
}

// All that the coupled hand computes is the full one's, projected by S: to rounding, lengths below 0.3 m.
TEST(CoupledJoints, AreTheFullHandProjected) {
  const Pair pair = several();
  const Hand &full = pair.full, &hand = pair.coupled_one;
  ASSERT_EQ(hand.joints.size(), 8U);
  ASSERT_EQ(hand.followers.size(), 4U);
  std::mt19937_64 random(5);
  HandPose pose, all;
  MatrixXd H(8, std::ssize(hand.muscles)), H_all(12, std::ssize(hand.muscles));
  for (int i = 0; i < 100; ++i) {
    const JointVector q = random_q(hand, random);
    forward_kinematics(hand, q, pose);
    forward_kinematics(full, pair.all(q), all);
    for (std::size_t s = 0; s < hand.segments.size(); ++s) {
      EXPECT_TRUE(pose.segments[s].isApprox(all.segments[s], 1e-14)) << hand.segments[s].name;
    }
    for (int k = 0; k < hand.fingers(); ++k) {
      const Fingertip &tip = hand.fingertips[k], &full_tip = full.fingertips[k];
      const Vector3d point_m = 0.1 * random_direction(random);
      const MatrixXd J_all =
          finger_jacobian(full, all, k, point_m) * pair.S.block(full_tip.first_joint, tip.first_joint, 4, tip.joints);
      const FingerJacobian J = finger_jacobian(hand, pose, k, point_m);
      EXPECT_LT((J.leftCols(tip.joints) - J_all).norm(), 1e-15);
      EXPECT_TRUE(J.rightCols(J.cols() - tip.joints).isZero(0.0));
    }
    const Vector3d gravity = 9.81 * random_direction(random);
    EXPECT_LT((gravity_torques(hand, pose, gravity) - pair.S.transpose() * gravity_torques(full, all, gravity)).norm(),
              1e-15);
    moment_arms(hand, pose, H);
    moment_arms(full, all, H_all);
    EXPECT_LT((H - pair.S.transpose() * H_all).norm(), 1e-15);
    const Hand other = mirrored(hand);
    HandPose image;
    forward_kinematics(other, q, image);
    for (int k = 0; k < hand.fingers(); ++k) {
      Vector3d tip_m = pose.distal(hand, k) * hand.fingertips[k].centre_m;
      tip_m.z() = -tip_m.z();
      EXPECT_LT((image.distal(other, k) * other.fingertips[k].centre_m - tip_m).norm(), 1e-15);
    }
  }
}

// J, its axes and g against central differences of the forward kinematics: steps of 1e-5 leave errors of 1e-10 of the
// third derivatives, which are below 1 m and 1 J, and 1e-11 of rounding. A joint turns a fingertip by up to a = 2.4
// times its angle, and the sine of 2 a steps falls short of them by (2 a 1e-5)^2 a / 6 = 1e-9 of a step.
TEST(CoupledJoints, MoveAsFiniteDifferencesSay) {
  const Hand hand = several().coupled_one;
  constexpr double kStep = 1e-5, kError = 5e-10, kSine = 1e-9;
  const Vector3d gravity(3.0, -7.0, 5.0);
  std::mt19937_64 random(6);
  for (int i = 0; i < 20; ++i) {
    const JointVector q = random_q(hand, random);
    HandPose pose, plus, minus;
    forward_kinematics(hand, q, pose);
    const JointVector g = gravity_torques(hand, pose, gravity);
    for (int k = 0; k < hand.fingers(); ++k) {
      const Fingertip& tip = hand.fingertips[k];
      const Vector3d point_m = pose.distal(hand, k) * tip.centre_m;
      const FingerJacobian J = finger_jacobian(hand, pose, k, point_m), axes = turning_axes(hand, pose, k);
      for (int j = 0; j < tip.joints; ++j) {
        JointVector dq = hand.at_zero();
        dq[tip.first_joint + j] = kStep;
        forward_kinematics(hand, q + dq, plus);
        forward_kinematics(hand, q - dq, minus);
        const Vector3d way = plus.distal(hand, k) * tip.centre_m - minus.distal(hand, k) * tip.centre_m;
        EXPECT_LT((J.col(j) - way / (2.0 * kStep)).norm(), kError);
        const Matrix3d turn = plus.distal(hand, k).linear() * minus.distal(hand, k).linear().transpose();
        const Vector3d w(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1));
        EXPECT_LT((axes.col(j) - w / (4.0 * kStep)).norm(), kError + kSine);
        double potential_J = 0.0;
        for (std::size_t s = 0; s < hand.segments.size(); ++s) {
          const Segment& segment = hand.segments[s];
          potential_J -=
              segment.mass_kg * gravity.dot(plus.segments[s] * segment.com_m - minus.segments[s] * segment.com_m);
        }
        EXPECT_NEAR(g[tip.first_joint + j], potential_J / (2.0 * kStep), kError);
      }
    }
  }
}

// W = h J_c S (S' b S)^-1 S' J_c' + ..., with the full hand's Jacobians at the same contacts, and b of all its joints.
TEST(CoupledJoints, HaveTheDelassusOperatorOfTheProjectedHand) {
  const Scene plain = scene_of("box_grasp", {kCoarseBox, "contact.level=2"});
  for (const bool own : {false, true}) {
    Scene scene = with_coupled_ends(plain);
    if (own) scene.hand.fingertips[1].joint_viscosity = 0.21;
    Loop loop(scene);
    loop.run(0.05);
    contact_kinematics(loop.model, loop.frame, loop.work.pose, loop.state, loop.work.kinematics);
    const ContactKinematics& now = loop.work.kinematics;
    const Mobility all = mobility(loop.model.scene);
    set_shares(loop.model, loop.frame, all, loop.work.kinematics);
    const MatrixXd W = dense_delassus(loop.model, loop.frame, now, all);
    Mobility still = all;
    still.joint = 0.0;
    still.root.resize(0);
    MatrixXd expected = dense_delassus(loop.model, loop.frame, now, still);

    const Hand& hand = loop.model.scene.hand;
    JointVector q = plain.hand.at_zero();
    HandPose pose;
    for (int k = 0; k < hand.fingers(); ++k) {
      const Fingertip& tip = hand.fingertips[k];
      q.segment(plain.hand.fingertips[k].first_joint, tip.joints) = loop.state.q.segment(tip.first_joint, tip.joints);
    }
    for (const Follower& follower : hand.followers) q[follower.leader < 7 ? 7 : 11] = follower.angle(loop.state.q);
    forward_kinematics(plain.hand, q, pose);
    for (int k = 0; k < hand.fingers(); ++k) {
      const int joints = hand.fingertips[k].joints;
      MatrixXd S = MatrixXd::Identity(4, joints);
      if (joints == 3) S(3, 2) = 0.7;
      const double b = hand.fingertips[k].joint_viscosity.value_or(scene.joint_viscosity);
      const Index first = loop.frame.begin[k], n = loop.frame.begin[k + 1] - first;
      MatrixXd J(3 * n, joints);
      for (Index i = 0; i < n; ++i) {
        const MatrixXd J_i = finger_jacobian(plain.hand, pose, k, now.c_W[first + i]);
        J.middleRows(3 * i, 3) = -now.E_W[first + i].transpose() * J_i * S;
      }
      const MatrixXd B = b * S.transpose() * S;
      expected.block(3 * first, 3 * first, 3 * n, 3 * n) += scene.step_s * J * B.inverse() * J.transpose();
    }
    EXPECT_GT(loop.frame.size(), 10);
    EXPECT_LT((W - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
  }
}

// Without contact: the torque tau_a of a leader turns it with h tau_a / (b (1 + ratio^2)), and its work is what the
// viscosities of both joints take. At the end of the follower's range the leader stops, and no energy comes from there.
TEST(CoupledJoints, TurnAgainstBothViscositiesUpToTheFirstLimit) {
  constexpr int kJoint = 6;
  Scene plain = scene_of("minimal", {"gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]"});
  plain.control.reset();
  plain.object.X_WO.translation().x() += 1.0;
  plain.hand.joints[kJoint + 1].upper_rad = plain.posture[kJoint + 1] + 0.7 * 0.01;
  Scene scene = with_coupled_ends(plain);
  scene.torques = scene.hand.at_zero();
  (*scene.torques)[kJoint] = 0.02;
  EXPECT_NEAR(scene.hand.joints[kJoint].upper_rad - scene.posture[kJoint], 0.01, 1e-15);
  Loop loop(scene);
  const double h = scene.step_s, b = scene.joint_viscosity;
  bool stopped = false;
  for (int tick = 0; tick < 400; ++tick) {
    const TickReport report = loop.tick();
    const double way = std::min(0.01, h * 0.02 / (b * 1.49) * (tick + 1));
    EXPECT_NEAR(loop.state.q[kJoint] - scene.posture[kJoint], way, 1e-14 * (tick + 1));
    EXPECT_LE(loop.model.scene.hand.followers[0].angle(loop.state.q), plain.hand.joints[kJoint + 1].upper_rad + 1e-15);
    EXPECT_EQ(report.ledger.injected_J, 0.0);
    EXPECT_NEAR(report.ledger.unbalanced_J(), 0.0, 1e-18);
    stopped = stopped || report.stop_Nm[kJoint] < -0.019;
  }
  EXPECT_TRUE(stopped);
}

/// The angle by which a follower's joint has turned from q = 0, from the poses of the segments at its ends alone.
double angle_of(const Hand& hand, const HandPose& pose, int before, int behind, const Vector3d& axis_0) {
  const Matrix3d at_zero = hand.segments[before].X_WS_0.linear().transpose() * hand.segments[behind].X_WS_0.linear();
  const Matrix3d now = pose.segments[before].linear().transpose() * pose.segments[behind].linear();
  const Eigen::AngleAxisd turn(now * at_zero.transpose());
  const Vector3d axis = hand.segments[before].X_WS_0.linear().transpose() * axis_0;
  return turn.angle() * (turn.axis().dot(axis) > 0.0 ? 1.0 : -1.0);
}

/// What a run of a grasp that carries its box leaves: how far the object is off its target at the end, and the ledger.
struct Carried {
  double miss_m = 0.0;
  Ledger sum;
};

Carried carry(GraspRun& run, const Model& model) {
  const Hand& hand = model.scene.hand;
  Carried carried;
  HandPose pose;
  while (run.time_s() < model.scene.duration_s) {
    const TickReport report = run.tick();
    carried.sum.add(report.ledger);
    EXPECT_NE(report.solve.status, SolveStatus::kNotFinite);
    EXPECT_NEAR(report.ledger.unbalanced_J(), 0.0, 1e-12);
    if (run.state.tick % 50 != 0) continue;
    forward_kinematics(hand, run.state.q, pose);
    for (const Follower& follower : hand.followers) {
      const int k = follower.leader < 7 ? 1 : 2, behind = hand.fingertips[k].segment;
      // The axes are given with 6 digits, and the segments' rotations, too.
      const double angle = angle_of(hand, pose, behind - 1, behind, follower.joint.axis);
      EXPECT_NEAR(angle, follower.ratio * run.state.q[follower.leader] + follower.offset_rad, 1e-9);
    }
  }
  for (int k = 0; k < hand.fingers(); ++k) EXPECT_GT(run.state.load[k].normal_N, 0.2);
  carried.miss_m = (run.state.X_WO.translation() - model.target(run.time_s()).translation()).norm();
  return carried;
}

/// As near to the target as the hand whose joints all turn by themselves, to 0.1 mm, and with no more energy from
/// nowhere, to a tenth: it comes where contacts start a tick pressed in, and couplings make none.
void expect_as_good(const Carried& coupled_one, const Carried& full) {
  EXPECT_LT(coupled_one.miss_m, full.miss_m + 1e-4);
  EXPECT_LT(coupled_one.sum.injected_J, 1.1 * full.sum.injected_J);
}

// A thumb of four joints, of which the last takes a fifth along, and so has more drag: the spring of the posture moves
// its joints, and no fingertip. Torques of 0.1 N m move joints by at most 4 rad/s; 1e-12 m/s is rounding.
TEST(CoupledJoints, ArePulledBackToTheirPostureWithoutTheirFingertip) {
  Scene scene = scene_of("box_grasp");
  Hand& hand = scene.hand;
  hand.muscles.clear();
  Joint fifth = hand.joints[3];
  fifth.name = "fifth";
  fifth.axis = (fifth.axis + 0.3 * Vector3d::UnitX()).normalized();
  hand.joints.insert(hand.joints.begin() + 4, fifth);
  ++hand.fingertips[0].joints;
  for (int k = 1; k < hand.fingers(); ++k) ++hand.fingertips[k].first_joint;
  ++hand.segments[hand.fingertips[0].segment].joints;
  hand = coupled(hand, {{{4, 3, 0.7, 0.0}}});
  ASSERT_EQ(hand.fingertips[0].joints, 4);
  Model model = build_model(scene_of("box_grasp", {kCoarseBox}));
  model.scene = scene;
  std::mt19937_64 random(12);
  HandPose pose;
  const FingerForces none = FingerForces::Zero(3, 3);
  for (int i = 0; i < 20; ++i) {
    JointVector q = scene.posture;
    for (Index j = 0; j < 4; ++j) q[j] += uniform(random, -0.2, 0.2);
    forward_kinematics(hand, q, pose);
    PerFinger<GraspContact> contacts(3);
    contacts[0].point_m = pose.distal(hand, 0) * hand.fingertips[0].centre_m;
    Model slack = model;
    slack.scene.control->posture_Nm_per_rad.reset();
    const JointVector tau = desired_torques(model, q, pose, model.scene.gravity, contacts, none, none) -
                            desired_torques(slack, q, pose, slack.scene.gravity, contacts, none, none);
    VectorXd dq = tau.head(4) / scene.joint_viscosity;
    for (Index j = 0; j < 4; ++j) dq[j] /= hand.joints[j].drag;
    EXPECT_GT(dq.norm(), 1e-4);
    const FingerJacobian J = finger_jacobian(hand, pose, 0, contacts[0].point_m);
    EXPECT_LT((J.leftCols(4) * dq).norm(), 1e-12);
  }
}

// The three-finger hand with coupled ends carries its box by 20 mm with muscles, in one loop, and with torques in
// lockstep.
TEST(CoupledJoints, CarryABox) {
  const std::vector<std::string> faster{kCoarseBox, "contact.level=2", "time.duration=1.6 s"};
  {
    const Scene plain = scene_of("box_grasp", faster);
    Loop loop(with_coupled_ends(plain)), full(plain);
    expect_as_good(carry(loop, loop.model), carry(full, full.model));
  }
  std::vector<std::string> split = faster;
  split.insert(split.end(), {"control.muscles=false", "time.step=1 ms", "time.control_period=5 ms"});
  const Scene plain = scene_of("box_grasp", split);
  const Model model = build_model(with_coupled_ends(plain)), all = build_model(plain);
  GraspRun run(model, LockstepSettings{}), full(all, LockstepSettings{});
  expect_as_good(carry(run, model), carry(full, all));
}

TEST(CoupledJoints, TakeNoMemoryInATick) {
  Loop loop(with_coupled_ends(scene_of("box_grasp", {kCoarseBox, "contact.level=2"})));
  loop.run(0.02);
  const AllocationCounter counter;
  for (int i = 0; i < 20; ++i) loop.tick();
  EXPECT_EQ(counter.count(), 0);
}

TEST(CoupledJoints, SayWhatDoesNotFit) {
  const Hand hand = scene_of("box_grasp").hand;
  const auto fault = [&](const std::vector<Coupling>& couplings) { return coupling_fault(hand, couplings); };
  EXPECT_EQ(fault({{7, 6, 0.7, 0.0}}), "");
  EXPECT_EQ(fault({{7, 10, 0.7, 0.0}}), "'M_PIP_FE' is a joint of another finger: a joint follows one of its own");
  EXPECT_EQ(fault({{6, 7, 0.7, 0.0}}), "'I_DIP_FE' is no nearer to the palm: let that joint follow this one");
  EXPECT_EQ(fault({{6, 6, 0.7, 0.0}}), "'I_PIP_FE' is no nearer to the palm: let that joint follow this one");
  EXPECT_EQ(fault({{6, 4, 0.7, 0.0}, {7, 6, 0.7, 0.0}}), "'I_PIP_FE' follows a joint itself: name that one");
  EXPECT_EQ(fault({{7, 6, 0.0, 0.0}}), "with a ratio of zero it would not turn: leave the joint out");
  // Their ranges are 0 .. 1.5708 both.
  EXPECT_EQ(fault({{7, 6, 1.0, 1.6}}), "no range of 'I_PIP_FE' keeps what follows it within its limits");
  const Hand made = coupled(hand, std::vector<Coupling>{{7, 6, -0.5, 0.6}});
  EXPECT_DOUBLE_EQ(made.joints[6].lower_rad, 0.0);
  EXPECT_NEAR(made.joints[6].upper_rad, 1.2, 1e-15) << "where the follower is at 0";
  EXPECT_DOUBLE_EQ(made.joints[6].drag, 1.25);
}

}  // namespace
}  // namespace thenar::coupled_joints_test
