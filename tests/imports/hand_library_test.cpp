// SPDX-License-Identifier: Apache-2.0
// The hands of configs/hands.

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>
#include <filesystem>
#include <string>

#include "engine/hand/muscles.h"
#include "engine/imports/crossing_fit.h"
#include "engine/scenes/hand_file.h"
#include "solvers/muscles/muscle_forces.h"

namespace thenar::hand_library_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Hand library_hand(const std::string& name) {
  return load_hand(std::filesystem::path(THENAR_CONFIGS) / "hands" / (name + ".yaml"));
}

TEST(HandLibrary, HoldsHandsOfTheseSizes) {
  const auto expect = [](const std::string& name, int fingers, int joints, int muscles) {
    const Hand hand = library_hand(name);
    EXPECT_EQ(hand.fingers(), fingers) << name;
    EXPECT_EQ(std::ssize(hand.joints), joints) << name;
    EXPECT_EQ(std::ssize(hand.muscles), muscles) << name;
    EXPECT_EQ(hand.fingertips.front().finger, "thumb") << name;
  };
  expect("three_finger", 3, 12, 23);
  expect("human5", 5, 20, 38);
  expect("leap", 4, 16, 0);
  expect("allegro", 4, 16, 0);
}

// X distal, Y palmar, Z radial: fingers reach along X, their pulps look along Y, and the index is on the thumb's side.
TEST(HandLibrary, HandsHaveTheSameAxes) {
  for (const char* name : {"three_finger", "human5", "leap", "allegro"}) {
    const Hand hand = library_hand(name);
    double last_z_m = 1.0;
    for (int k = 1; k < hand.fingers(); ++k) {
      const Fingertip& tip = hand.fingertips[k];
      const Segment& distal = hand.segments[tip.segment];
      const Vector3d reach = distal.X_WS_0 * tip.centre_m - hand.joints[tip.first_joint].origin_m;
      EXPECT_GT(reach.normalized().x(), 0.9) << name << " " << tip.finger;
      EXPECT_GT((distal.X_WS_0.linear() * tip.normal).y(), 0.5) << name << " " << tip.finger;
      const double z_m = hand.joints[tip.first_joint].origin_m.z();
      EXPECT_LT(z_m, last_z_m) << name << " " << tip.finger;
      last_z_m = z_m;
    }
  }
}

// The five-finger hand's first three fingers are the three-finger hand's.
TEST(HandLibrary, TheHumanHandBeginsAsTheThreeFingerHand) {
  const Hand three = library_hand("three_finger"), five = library_hand("human5");
  for (std::size_t j = 0; j < three.joints.size(); ++j) {
    EXPECT_EQ(five.joints[j].name, three.joints[j].name);
    EXPECT_EQ(five.joints[j].axis, three.joints[j].axis);
  }
  for (std::size_t m = 0; m < three.muscles.size(); ++m) EXPECT_EQ(five.muscles[m].name, three.muscles[m].name);
}

// Every torque can be had from pulling muscles exactly if H has full rank and H f = 0 for some f > 0. A solution of
// H f = -H 1, f >= 0 gives it: f + 1. A singular value of 0.5 mm is a twentieth of a usual moment arm.
TEST(HandLibrary, MusclesOfTheHumanHandSpanEveryTorque) {
  const Hand hand = library_hand("human5");
  const Index joints = std::ssize(hand.joints), muscles = std::ssize(hand.muscles);
  MatrixXd H(joints, muscles);
  VectorXd f(muscles);
  double least = 1.0;
  for (const HandPose& pose : random_poses(hand, 500, 11)) {
    moment_arms(hand, pose, H);
    least = std::min(least, H.jacobiSvd().singularValues()[joints - 1]);
    const VectorXd tau = -H.rowwise().sum();
    ASSERT_EQ(solve_muscle_forces({H, tau}, f).status, MuscleStatus::kOptimal);
    EXPECT_GE(f.minCoeff(), 0.0);
  }
  EXPECT_GT(least, 0.5e-3);
}

}  // namespace
}  // namespace thenar::hand_library_test
