// SPDX-License-Identifier: Apache-2.0
#include "engine/hand/muscles.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>

#include "engine/hand/coupled_joints.h"
#include "engine/scenes/hand_file.h"
#include "tests/support/scenes.h"

namespace thenar::muscles_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

HandPose pose_at(const Hand& hand, const JointVector& q) {
  HandPose pose;
  forward_kinematics(hand, q, pose);
  return pose;
}

JointVector random_posture(const Hand& hand, std::mt19937_64& random) {
  JointVector q = hand.at_zero();
  for (Index i = 0; i < q.size(); ++i) q[i] = uniform(random, hand.joints[i].lower_rad, hand.joints[i].upper_rad);
  return q;
}

/// Central differences in every joint. A step of 1e-5 leaves its square's share of third derivatives, and 1e-16 / 1e-5:
/// below 1e-10 of values below 1.
template <typename Value>
MatrixXd gradient(const JointVector& q, Value value) {
  constexpr double h = 1e-5;
  MatrixXd columns(VectorXd(value(q)).size(), q.size());
  for (Index i = 0; i < q.size(); ++i) {
    const JointVector step = h * JointVector::Unit(q.size(), i);
    columns.col(i) = (VectorXd(value(q + step)) - VectorXd(value(q - step))) / (2.0 * h);
  }
  return columns;
}

MatrixXd arms(const Hand& hand, const HandPose& pose) {
  MatrixXd H(std::ssize(hand.joints), std::ssize(hand.muscles));
  moment_arms(hand, pose, H);
  return H;
}

/// A finger's part of a matrix over all joints.
MatrixXd block(const Hand& hand, const MatrixXd& all, int k) {
  const Fingertip& tip = hand.fingertips[k];
  return all.block(tip.first_joint, tip.first_joint, tip.joints, tip.joints);
}

/// Muscles of a hand that others describe, with 60 mm of fibres and some tendons.
Hand with_fibres(Hand hand) {
  for (std::size_t m = 0; m < hand.muscles.size(); ++m) {
    hand.muscles[m].fibre_m = 0.06;
    if (m % 3 == 0) hand.muscles[m].tendon_N_per_m = 2e4;
  }
  return hand;
}

/// The index's last joint follows its middle one, and the thumb's first its second's.
Hand coupled_human() {
  const Hand hand = load_hand(config_file("hand"));
  return coupled(hand, std::vector<Coupling>{{7, 6, 0.7, 0.1}, {3, 2, -0.5, 0.2}});
}

class Muscles : public testing::TestWithParam<std::string> {
 protected:
  Hand hand = with_fibres(GetParam() == "coupled" ? coupled_human() : load_hand(config_file(GetParam())));
  std::mt19937_64 random{1};
};

// H is the derivative of lengths, to what differences can tell of lengths of 0.1 m.
TEST_P(Muscles, ArmsAreTheDerivativeOfLengths) {
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(trial);
    const JointVector q = random_posture(hand, random);
    const auto lengths = [&](const JointVector& at) { return muscle_lengths(hand, pose_at(hand, at)); };
    EXPECT_LE((arms(hand, pose_at(hand, q)).transpose() + gradient(q, lengths)).cwiseAbs().maxCoeff(), 1e-9);
  }
}

// So constant forces do no work on a closed path: dh_i/dq_k = dh_k/dq_i. The slopes are those of H, and fingers share
// none.
TEST_P(Muscles, ArmsHaveNoCurl) {
  std::vector<Belly> bellies = bellies_of(hand);
  for (int trial = 0; trial < 50; ++trial) {
    SCOPED_TRACE(trial);
    const JointVector q = random_posture(hand, random);
    find_bellies(hand, pose_at(hand, q), bellies);
    MatrixXd left = arms(hand, pose_at(hand, q));
    for (int m = 0; m < std::ssize(hand.muscles); ++m) {
      const auto column = [&](const JointVector& at) -> VectorXd { return arms(hand, pose_at(hand, at)).col(m); };
      MatrixXd slopes = gradient(q, column);
      EXPECT_LE((slopes - slopes.transpose()).cwiseAbs().maxCoeff(), 1e-9) << hand.muscles[m].name;
      for (const Belly& belly : bellies) {
        if (belly.muscle != m) continue;
        const Fingertip& tip = hand.fingertips[belly.finger];
        EXPECT_LE((block(hand, slopes, belly.finger) - belly.slopes_m).cwiseAbs().maxCoeff(), 1e-9);
        slopes.block(tip.first_joint, tip.first_joint, tip.joints, tip.joints).setZero();
        left.col(m).segment(tip.first_joint, tip.joints) -= belly.arms_m.head(tip.joints);
      }
      EXPECT_LE(slopes.cwiseAbs().maxCoeff(), 1e-9) << hand.muscles[m].name;
    }
    EXPECT_LE(left.cwiseAbs().maxCoeff(), 1e-16);
  }
}

// K of muscles whose force follows their length by k, against differences of H f: to 1e-6 of the whole.
TEST_P(Muscles, StiffnessIsTheDerivativeOfTheirTorque) {
  std::vector<Belly> bellies = bellies_of(hand);
  for (int trial = 0; trial < 20; ++trial) {
    SCOPED_TRACE(trial);
    const JointVector q = random_posture(hand, random);
    VectorXd f(std::ssize(hand.muscles));
    for (double& f_j : f) f_j = uniform(random, 0.0, 50.0);
    find_bellies(hand, pose_at(hand, q), bellies);
    for (int k = 0; k < hand.fingers(); ++k) {
      // Each belly by itself: a muscle on several fingers pulls each with its share.
      const auto torque = [&](const JointVector& at) {
        std::vector<Belly> there = bellies;
        find_bellies(hand, pose_at(hand, at), there);
        VectorXd tau = VectorXd::Zero(hand.fingertips[k].joints);
        for (std::size_t b = 0; b < bellies.size(); ++b) {
          if (bellies[b].finger != k) continue;
          const Muscle& muscle = hand.muscles[bellies[b].muscle];
          const double f_N = f[bellies[b].muscle];
          const double stretched_m =
              -bellies[b].arms_m.head(tau.size()).dot((at - q).segment(hand.fingertips[k].first_joint, tau.size())) /
              bellies[b].share;
          const double more_N =
              f_N > 0.0 ? stretched_m / (*muscle.fibre_m / (kShortRange * f_N) + 1.0 / muscle.tendon_N_per_m) : 0.0;
          tau += (f_N + more_N) * there[b].arms_m.head(tau.size());
        }
        return tau;
      };
      const MatrixXd K = muscle_stiffness(hand, bellies, k, kShortRange, f);
      const MatrixXd slope = gradient(q, torque).middleCols(hand.fingertips[k].first_joint, hand.fingertips[k].joints);
      EXPECT_LE((K + slope).cwiseAbs().maxCoeff(), 1e-6 * K.cwiseAbs().maxCoeff()) << k;
    }
  }
}

TEST_P(Muscles, WeightAndForcesStiffenByTheDerivativesOfTheirTorques) {
  for (int trial = 0; trial < 20; ++trial) {
    SCOPED_TRACE(trial);
    const JointVector q = random_posture(hand, random);
    const HandPose pose = pose_at(hand, q);
    const Vector3d gravity(3.0, -5.0, 8.0);
    const MatrixXd G = gradient(
        q, [&](const JointVector& at) -> VectorXd { return gravity_torques(hand, pose_at(hand, at), gravity); });
    for (int k = 0; k < hand.fingers(); ++k) {
      const Fingertip& tip = hand.fingertips[k];
      EXPECT_LE((gravity_stiffness(hand, pose, k, gravity) - block(hand, G, k)).cwiseAbs().maxCoeff(), 1e-9);
      const Vector3d p_F = 0.02 * random_direction(random), force_N = random_direction(random);
      const MatrixXd slope = gradient(q, [&](const JointVector& at) -> VectorXd {
        const HandPose there = pose_at(hand, at);
        const FingerJacobian J = finger_jacobian(hand, there, k, there.distal(hand, k) * p_F);
        return J.leftCols(tip.joints).transpose() * force_N;
      });
      const JointMatrix K =
          force_stiffness(hand, pose, hand.segments[tip.segment], pose.distal(hand, k) * p_F, force_N);
      EXPECT_LE((K - slope.middleCols(tip.first_joint, tip.joints)).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Hands, Muscles, testing::Values("hand", "hands/human5", "hands/three_finger", "coupled"),
                         [](const auto& given) {
                           std::string name = given.param;
                           std::ranges::replace(name, '/', '_');
                           return name;
                         });

// Fibres and a tendon in series: the softer one counts, and without force there is no stiffness.
TEST(MuscleStiffness, IsThatOfFibresAndTendonInSeries) {
  Muscle muscle{"", 100.0, {}, 0.05, 1e4};
  EXPECT_EQ(muscle_stiffness(muscle, 23.4, 0.0), 0.0);
  EXPECT_NEAR(1.0 / muscle_stiffness(muscle, 23.4, 10.0), 0.05 / (23.4 * 10.0) + 1e-4, 1e-18);
  muscle.tendon_N_per_m = std::numeric_limits<double>::infinity();
  EXPECT_DOUBLE_EQ(muscle_stiffness(muscle, 23.4, 10.0), 23.4 * 10.0 / 0.05);
}

}  // namespace
}  // namespace thenar::muscles_test
