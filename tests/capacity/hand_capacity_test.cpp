// SPDX-License-Identifier: Apache-2.0
// The largest forces that muscles can give.

#include "engine/capacity/hand_capacity.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "engine/studies/model_parts.h"
#include "tests/support/coupled_hand.h"
#include "tests/support/scenes.h"

namespace thenar::hand_capacity_test {
namespace {

using Eigen::Index;
using Eigen::Matrix2Xd;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// What a limit is proved to as a share of the largest bound, and its figures [N], for cones are left by 1e-7 of some
// 200 N.
constexpr double kProved = 1e-9, kAlike = 1e-4;

Model held_box() { return build_model(scene_of("box_grasp", {kCoarseBox, "fingertips.points=400"})); }

/// The box's hand, whose muscles have other forces.
class Box {
 public:
  Box() : model_(held_box()), hand_(model_.scene.hand) {}

  Muscle& muscle(const std::string& name) { return *std::ranges::find(hand_.muscles, name, &Muscle::name); }
  void scale(double factor) {
    for (Muscle& muscle : hand_.muscles) muscle.max_force_N *= factor;
  }
  [[nodiscard]] HandGrip grip() const {
    const HandGrip start = grip_at_start(model_);
    return {hand_, start.pose, start.contacts, start.centre_m};
  }
  [[nodiscard]] LargestForce pinch(double friction = 0.8) const { return largest_pinch(grip(), friction); }
  [[nodiscard]] bool limits(const std::string& name, const LargestForce& force) const {
    return std::ranges::any_of(force.limiting,
                               [&](const LimitingMuscle& limit) { return hand_.muscles[limit.muscle].name == name; });
  }

 private:
  Model model_;
  Hand hand_;
};

/// A finger of two joints about z, bones of 40 and 30 mm along x, pressing at its end; muscle m has these constant arms
/// about the joints [m] and this largest force.
Hand planar_finger(const Matrix2Xd& arms, const VectorXd& most) {
  Hand hand;
  Segment bone;
  bone.X_WS_0.setIdentity();
  hand.segments.push_back(bone);
  bone.joints = 1;
  hand.segments.push_back(bone);
  bone.joints = 2;
  bone.X_WS_0.translation() = Vector3d(0.04, 0, 0);
  hand.segments.push_back(bone);
  hand.joints = {{"near", Vector3d::Zero(), Vector3d::UnitZ(), -2.0, 2.0},
                 {"far", Vector3d(0.04, 0, 0), Vector3d::UnitZ(), -2.0, 2.0}};
  Fingertip tip;
  tip.finger = "finger";
  tip.joints = 2;
  tip.segment = 2;
  tip.centre_m = Vector3d(0.03, 0, 0);
  tip.normal = Vector3d::UnitY();
  hand.fingertips.push_back(tip);
  for (Index m = 0; m < arms.cols(); ++m) {
    Muscle muscle;
    muscle.name = "m" + std::to_string(m);
    muscle.max_force_N = most[m];
    // A pull along -x at y has the moment y about z, wherever it is.
    for (int j = 0; j < 2; ++j) {
      muscle.crossings.push_back({{j}, 1.0, j + 1, Vector3d(0.01, arms(j, m), 0), j + 1, -Vector3d::UnitX(), false});
    }
    hand.muscles.push_back(muscle);
  }
  return hand;
}

HandGrip planar_grip(const Hand& hand) {
  HandGrip grip{hand, {}, {}};
  forward_kinematics(hand, hand.at_zero(), grip.pose);
  Eigen::Matrix3d axes;  // n = y, tangents z and x.
  axes << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  grip.contacts.push_back({Vector3d(0.07, 0, 0), axes});
  return grip;
}

/// The largest s with arms f = tau s, 0 <= f <= most: the best of all vertices, where all but two muscles are at a
/// bound, or with s all but one.
double largest_by_vertices(const Matrix2Xd& arms, const VectorXd& most, const Vector2d& tau) {
  const Index n = arms.cols();
  double best = 0.0;
  for (Index free = 0; free < n; ++free) {
    for (int bits = 0; bits < 1 << n; ++bits) {
      VectorXd f(n);
      for (Index m = 0; m < n; ++m) f[m] = bits >> m & 1 ? most[m] : 0.0;
      f[free] = 0.0;
      Eigen::Matrix2d A;
      A << arms.col(free), -tau;
      if (std::abs(A.determinant()) < 1e-12) continue;
      const Vector2d x = A.inverse() * -(arms * f);
      if (x[0] >= -1e-9 && x[0] <= most[free] + 1e-9) best = std::max(best, x[1]);
    }
  }
  return best;
}

// Straight along x, a force s along y at 70 mm asks for 70 s and 30 s N mm. One flexor for each joint, arms of 10 and 5
// mm, gives 100 / 7 N by the first or 5 / 30 of the second.
TEST(HandCapacity, OfAFingerWithOneMuscleAJointIsThatOfItsWeakerJoint) {
  Matrix2Xd arms(2, 2);
  arms << 0.010, 0.0, 0.0, 0.005;
  for (const double second_N : {30.0, 150.0}) {
    const Hand hand = planar_finger(arms, Vector2d(100.0, second_N));
    const LargestForce force = largest_along(planar_grip(hand), 0, Vector3d::UnitY());
    ASSERT_EQ(force.status, LimitStatus::kOptimal);
    const double near_N = 100.0 * 10.0 / 70.0, far_N = second_N * 5.0 / 30.0;
    EXPECT_NEAR(force.force_N, std::min(near_N, far_N), kAlike);
    ASSERT_EQ(force.limiting.size(), 1U);
    EXPECT_EQ(force.limiting[0].muscle, near_N < far_N ? 0 : 1);
    EXPECT_NEAR(force.limiting[0].gain, near_N < far_N ? 10.0 / 70.0 : 5.0 / 30.0, kAlike);
    EXPECT_NEAR(force.limiting[0].share, 1.0, kAlike);
    // No extensor: nothing the other way. Along x the bones carry it.
    EXPECT_NEAR(largest_along(planar_grip(hand), 0, -Vector3d::UnitY()).force_N, 0.0, kAlike);
    EXPECT_EQ(largest_along(planar_grip(hand), 0, Vector3d::UnitX()).status, LimitStatus::kUnbounded);
  }
}

TEST(HandCapacity, OfPlanarFingersIsThatOfTheBestVertex) {
  std::mt19937_64 random(5);
  int pressed = 0;
  for (int i = 0; i < 300; ++i) {
    const Index n = 2 + i % 5;
    Matrix2Xd arms(2, n);
    VectorXd most(n);
    for (Index m = 0; m < n; ++m) {
      arms.col(m) << uniform(random, -0.010, 0.012), uniform(random, -0.006, 0.008);
      most[m] = uniform(random, 5.0, 200.0);
    }
    const Hand hand = planar_finger(arms, most);
    const double angle = uniform(random, 0.1, 3.0);
    const Vector3d direction(std::cos(angle), std::sin(angle), 0.0);
    const LargestForce force = largest_along(planar_grip(hand), 0, direction);
    ASSERT_EQ(force.status, LimitStatus::kOptimal) << i;
    const double expected = largest_by_vertices(arms, most, std::sin(angle) * Vector2d(0.07, 0.03));
    EXPECT_NEAR(force.force_N, expected, 1e-8 * most.maxCoeff()) << i;
    pressed += expected > 0.1 ? 1 : 0;
  }
  EXPECT_GT(pressed, 100);
}

// Programs of all sizes: x keeps its limits, and no other x can do better than what the prices say.
TEST(ForceLimit, ProvesItselfByDuality) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 200; ++i) {
    const Index muscles = 5 + i % 30, cones = 1 + i % 5, size = muscles + 3 * cones;
    ForceProgram program;
    program.friction = 0.2 + 0.2 * (i % 4);
    program.E.resize(4 + i % 8, size);
    program.c.setZero(size);
    program.most.resize(muscles);
    for (double& one : program.E.reshaped()) one = uniform(random, -1.0, 1.0);
    for (double& one : program.most) one = std::pow(10.0, uniform(random, 0.0, 2.5));
    for (Index k = 0; k < cones; ++k) program.cones.push_back(muscles + 3 * k);
    program.c[muscles] = 1.0;
    program.E.bottomRows(1) = program.E.topRows(2).colwise().sum();  // depends on others
    const ForceLimit limit = find_force_limit(program);
    if (limit.status == LimitStatus::kUnbounded) continue;  // Cones that squeeze one another need no muscle.
    ASSERT_EQ(limit.status, LimitStatus::kOptimal) << i << " " << limit.residual;
    const double unit = program.most.maxCoeff();
    EXPECT_LE((program.E * limit.x).cwiseAbs().maxCoeff(), 100.0 * kProved * unit) << i;
    EXPECT_GE(limit.x.head(muscles).minCoeff(), -kProved * unit);
    EXPECT_LE((limit.x.head(muscles) - program.most).maxCoeff(), kProved * unit);
    for (const Index n : program.cones)
      EXPECT_LE(limit.x.segment<2>(n + 1).norm(),
                program.friction * limit.x[n] + 1e-7 * std::max(unit, limit.x.norm()) + kProved * unit);
    EXPECT_GE(limit.price.minCoeff(), 0.0);
    EXPECT_NEAR(limit.price.dot(program.most), limit.value, kProved * unit) << i;
  }
}

TEST(HandCapacity, APinchIsInBalanceWithinItsLimits) {
  const Box box;
  const HandGrip grip = box.grip();
  for (const double friction : {0.3, 0.8}) {
    const LargestForce pinch = largest_pinch(grip, friction);
    ASSERT_EQ(pinch.status, LimitStatus::kOptimal) << friction << " " << pinch.residual;
    const double tolerance_N = 1e-4;
    EXPECT_LT(pinch.contacts_N.rowwise().sum().norm(), tolerance_N);
    Vector3d torque = Vector3d::Zero();
    MatrixXd H(std::ssize(grip.hand.joints), std::ssize(grip.hand.muscles));
    moment_arms(grip.hand, grip.pose, H);
    VectorXd tau = H * pinch.muscles_N;
    for (int k = 0; k < 3; ++k) {
      const GraspContact& contact = grip.contacts[k];
      const Vector3d f = pinch.contacts_N.col(k), f_C = contact.axes.transpose() * f;
      EXPECT_LE(f_C.tail<2>().norm(), friction * f_C[0] + tolerance_N);
      torque += contact.point_m.cross(f);
      tau.segment<4>(4 * k) -= finger_jacobian(grip.hand, grip.pose, k, contact.point_m).transpose() * f;
    }
    EXPECT_LT(torque.norm(), 0.1 * tolerance_N);
    EXPECT_LT(tau.norm(), 0.1 * tolerance_N);
    double shares = 0.0;
    for (const LimitingMuscle& limit : pinch.limiting) {
      shares += limit.share;
      EXPECT_NEAR(pinch.muscles_N[limit.muscle], grip.hand.muscles[limit.muscle].max_force_N, tolerance_N);
    }
    EXPECT_NEAR(shares, 1.0, 1e-6);
  }
}

TEST(HandCapacity, ScalesWithTheMuscles) {
  Box box;
  const double once_N = box.pinch().force_N;
  box.scale(2.0);
  EXPECT_NEAR(box.pinch().force_N, 2.0 * once_N, kAlike);
}

TEST(HandCapacity, GrowsWithFriction) {
  const Box box;
  double last_N = 0.0;
  for (const double friction : {0.0, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6}) {
    const LargestForce pinch = box.pinch(friction);
    ASSERT_EQ(pinch.status, LimitStatus::kOptimal) << friction << " " << pinch.residual;
    EXPECT_GE(pinch.force_N, last_N - kAlike) << friction;
    last_N = pinch.force_N;
  }
  EXPECT_GT(last_N, 10.0);
}

// A price is the slope of the largest force over the muscle's, and is paid no more once others limit.
TEST(HandCapacity, PricesTellWhatAStrongerMuscleGives) {
  Box box;
  const LargestForce first = box.pinch();
  ASSERT_FALSE(first.limiting.empty());
  const std::string name = box.grip().hand.muscles[first.limiting[0].muscle].name;
  Muscle& muscle = box.muscle(name);
  const double was_N = muscle.max_force_N;
  muscle.max_force_N = was_N + 0.01;
  // The largest force is concave in the limits.
  const double gained = (box.pinch().force_N - first.force_N) / 0.01;
  EXPECT_LE(gained, first.limiting[0].gain + 1e-3);
  EXPECT_GE(gained, 0.9 * first.limiting[0].gain - 1e-3);

  muscle.max_force_N = 1e4;
  const LargestForce stronger = box.pinch();
  EXPECT_GT(stronger.force_N, first.force_N);
  EXPECT_FALSE(box.limits(name, stronger));
  EXPECT_FALSE(stronger.limiting.empty());
}

// The controller shares a squeeze among fingers and cones its own way: its largest pinch is below the largest of all,
// by not too much, and what is a little above it is over a muscle's limit.
TEST(HandCapacity, BoundsWhatARunCanSqueeze) {
  const auto squeezed_by = [](const std::string& newtons) {
    return build_model(
        scene_of("pinch_max", {kCoarseBox, "time.duration=0.6 s", "control.grasp.internal_force=" + newtons}));
  };
  const Model model = squeezed_by("30 N");
  const LargestForce most = largest_pinch(grip_at_start(model), 0.8);
  GraspRun run(model);
  while (run.time_s() < 0.6 - 1e-9) run.tick();
  const double thumb_N = run.state.load[0].normal_N;
  EXPECT_LT(thumb_N, most.force_N);
  EXPECT_GT(thumb_N, 0.8 * most.force_N);
  EXPECT_EQ(run_path(model).verdict.outcome, Outcome::kHeld);
  const Verdict beyond = run_path(squeezed_by("32 N")).verdict;
  EXPECT_EQ(beyond.outcome, Outcome::kOverLimits);
  EXPECT_NE(beyond.reason.find("the muscle "), std::string::npos) << beyond.reason;
}

// Joints that follow others have muscles, too: the torques of both act on the leader.
TEST(HandCapacity, OfAHandWithCoupledJointsIsFound) {
  const Model model = build_model(with_coupled_ends(scene_of("box_grasp", {kCoarseBox, "fingertips.points=400"})));
  const HandGrip grip = grip_at_start(model);
  const LargestForce pinch = largest_pinch(grip, 0.8);
  ASSERT_EQ(pinch.status, LimitStatus::kOptimal);
  // Fewer joints to hold: what the free hand can give, the coupled one can.
  EXPECT_GE(pinch.force_N, largest_pinch(grip_at_start(held_box()), 0.8).force_N - kAlike);
}

TEST(HandCapacity, FrictionAcrossHelpsAFinger) {
  const Box box;
  const HandCapacity capacity = hand_capacity(box.grip(), 0.8);
  ASSERT_EQ(capacity.fingers.size(), 3U);
  for (const FingerCapacity& finger : capacity.fingers) {
    ASSERT_EQ(finger.normal.status, LimitStatus::kOptimal);
    EXPECT_GE(finger.normal_with_friction.force_N, finger.normal.force_N - kAlike);
    EXPECT_EQ(finger.ring.size(), 12U);
    for (const PressDirection& press : finger.ring) EXPECT_EQ(press.largest.status, LimitStatus::kOptimal);
  }
  // Nobody's thumb gives less alone than it does in a pinch.
  EXPECT_GE(capacity.fingers[0].normal_with_friction.force_N, capacity.pinch.force_N - kAlike);
}

}  // namespace
}  // namespace thenar::hand_capacity_test
