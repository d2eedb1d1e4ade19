// SPDX-License-Identifier: Apache-2.0
#include "engine/hand/hand.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <random>

#include "engine/hand/muscles.h"
#include "engine/scenes/hand_file.h"
#include "solvers/grasp_forces.h"
#include "solvers/muscles/muscle_forces.h"
#include "tests/support/json_eigen.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::hand_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// The hand at the posture of the reference, which another program computed from the same hand file.
class HandReference : public testing::Test {
 protected:
  HandReference() : reference(read_json(THENAR_TEST_DATA "/hand_reference.json")) {
    q0 = vector_of(reference.at("q0"));
    forward_kinematics(hand, q0, pose);
    contact_points_m = matrix_of(reference.at("contact_points")).transpose();
    for (int k = 0; k < kFingers; ++k) contacts.push_back({contact_points_m.col(k), matrix_of(reference.at("B")[k])});
    object_centre_m = vector_of(reference.at("object_centre"));
  }

  nlohmann::json reference;
  Hand hand = load_hand(config_file("hand"));
  JointVector q0;
  HandPose pose;
  Eigen::Matrix3Xd contact_points_m;
  std::vector<GraspContact> contacts;
  Vector3d object_centre_m;
};

// Both programs compute in double precision from the same numbers: 1e-9 leaves room for the order of operations alone.
constexpr double kRelative = 1e-9;

// The reference takes the file's segment frames as printed, with six digits; ours are rotations.
constexpr double kPrinted = 1e-5;

TEST_F(HandReference, MomentArms) {
  MatrixXd H(kJoints, 23);
  moment_arms(hand, pose, H);
  EXPECT_TRUE(H.isApprox(matrix_of(reference.at("moment_arms")), kPrinted));
  // The names give the order of rows and columns.
  for (int i = 0; i < kJoints; ++i) EXPECT_EQ(hand.joints[i].name, reference.at("joint_names")[i].get<std::string>());
  for (int m = 0; m < 23; ++m) EXPECT_EQ(hand.muscles[m].name, reference.at("muscle_names")[m].get<std::string>());
}

TEST_F(HandReference, GraspMap) {
  MatrixXd G(6, 9);
  grasp_map(contacts, object_centre_m, G);
  EXPECT_TRUE(G.isApprox(matrix_of(reference.at("G")), kRelative));
}

TEST_F(HandReference, Jacobians) {
  for (int k = 0; k < kFingers; ++k) {
    SCOPED_TRACE(k);
    const FingerJacobian J = finger_jacobian(hand, pose, k, contact_points_m.col(k));
    EXPECT_TRUE(J.isApprox(matrix_of(reference.at("J")[k]), kRelative));
  }
}

TEST_F(HandReference, GravityTorques) {
  const Vector3d up = matrix_of(reference.at("object_rotation")).col(2);
  const JointVector g = gravity_torques(hand, pose, -9.81 * up);
  EXPECT_TRUE(g.isApprox(vector_of(reference.at("gravity_term")), kPrinted));
}

// The optimum of a strictly convex problem is unique, so two programs must meet; 1e-6 N is the reference's own
// accuracy.
TEST_F(HandReference, GraspForces) {
  ASSERT_EQ(reference.at("grasp").size(), 25);
  for (std::size_t i = 0; i < 25; ++i) {
    SCOPED_TRACE(i);
    const auto& recorded = reference.at("grasp")[i];
    const GraspProblem problem{.contacts = contacts,
                               .centre_m = object_centre_m,
                               .wrench = vector_of(recorded.at("W")),
                               .friction = recorded.at("mu"),
                               .internal_force_N = recorded.at("lam")};
    VectorXd f(9);
    const GraspReport report = solve_grasp_forces(problem, f);
    if (recorded.at("f").is_null()) {
      EXPECT_EQ(report.status, GraspStatus::kInfeasible);
      continue;
    }
    ASSERT_EQ(report.status, GraspStatus::kOptimal);
    EXPECT_LE((f - vector_of(recorded.at("f"))).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST_F(HandReference, MuscleForces) {
  const MatrixXd H = matrix_of(reference.at("H"));
  ASSERT_EQ(reference.at("muscle").size(), 25);
  for (std::size_t i = 0; i < 25; ++i) {
    SCOPED_TRACE(i);
    const auto& recorded = reference.at("muscle")[i];
    VectorXd f(H.cols());
    const MuscleReport report = solve_muscle_forces({H, vector_of(recorded.at("tau"))}, f);
    if (recorded.at("f").is_null()) {
      EXPECT_EQ(report.status, MuscleStatus::kInfeasible);
      continue;
    }
    ASSERT_EQ(report.status, MuscleStatus::kOptimal);
    EXPECT_LE((f - vector_of(recorded.at("f"))).cwiseAbs().maxCoeff(), 1e-6);
  }
}

JointVector random_posture(const Hand& hand, std::mt19937_64& random) {
  JointVector q = hand.at_zero();
  for (int i = 0; i < kJoints; ++i) q[i] = uniform(random, hand.joints[i].lower_rad, hand.joints[i].upper_rad);
  return q;
}

HandPose pose_at(const Hand& hand, const JointVector& q) {
  HandPose pose;
  forward_kinematics(hand, q, pose);
  return pose;
}

/// Central difference of `value(q)` in every joint. With h = 1e-5 both its errors, h^2/6 times the third derivative and
/// 1e-16 / h, stay below 1e-10 of values that are below 1.
template <typename Value>
MatrixXd gradient(const JointVector& q, Value value) {
  constexpr double h = 1e-5;
  MatrixXd columns(VectorXd(value(q)).size(), kJoints);
  for (int i = 0; i < kJoints; ++i) {
    const JointVector step = h * JointVector::Unit(kJoints, i);
    columns.col(i) = (VectorXd(value(q + step)) - VectorXd(value(q - step))) / (2.0 * h);
  }
  return columns;
}
constexpr double kDifference = 1e-10;

class RandomPostures : public testing::Test {
 protected:
  Hand hand = load_hand(config_file("hand"));
  std::mt19937_64 random{1};
};

// J is the derivative of the position of a point of the distal segment, and other fingers' joints do not move it.
TEST_F(RandomPostures, JacobianIsTheDerivativeOfForwardKinematics) {
  for (int trial = 0; trial < 20; ++trial) {
    SCOPED_TRACE(trial);
    const JointVector q = random_posture(hand, random);
    for (int k = 0; k < kFingers; ++k) {
      const Vector3d p_F = 0.02 * random_direction(random);
      const auto point = [&](const JointVector& at) -> VectorXd { return pose_at(hand, at).distal(hand, k) * p_F; };
      MatrixXd J = MatrixXd::Zero(3, kJoints);
      J.middleCols<kJointsPerFinger>(kJointsPerFinger * k) = finger_jacobian(hand, pose_at(hand, q), k, point(q));
      EXPECT_LE((J - gradient(q, point)).cwiseAbs().maxCoeff(), kDifference);
    }
  }
}

// g of b qdot + g = tau is the derivative of the weight's potential, -sum m gravity . x_com. Gravity is taken from no
// axis.
TEST_F(RandomPostures, GravityTorquesAreTheDerivativeOfThePotential) {
  const Vector3d gravity(3.0, -5.0, 8.0);
  for (int trial = 0; trial < 20; ++trial) {
    SCOPED_TRACE(trial);
    const JointVector q = random_posture(hand, random);
    const auto potential = [&](const JointVector& at) -> VectorXd {
      const HandPose pose = pose_at(hand, at);
      double V = 0.0;
      for (std::size_t s = 0; s < hand.segments.size(); ++s) {
        V -= hand.segments[s].mass_kg * gravity.dot(pose.segments[s] * hand.segments[s].com_m);
      }
      return VectorXd::Constant(1, V);
    };
    const JointVector g = gravity_torques(hand, pose_at(hand, q), gravity);
    EXPECT_LE((g.transpose() - gradient(q, potential)).cwiseAbs().maxCoeff(), kDifference);
  }
}

// Virtual work: where a tendon runs straight to a point that the joint does not move, its moment arm is the rate at
// which it shortens.
TEST_F(RandomPostures, MomentArmOfAStraightTendonIsItsExcursion) {
  int tendons = 0;
  MatrixXd H(kJoints, hand.muscles.size());
  for (std::size_t m = 0; m < hand.muscles.size(); ++m) {
    const auto& crossings = hand.muscles[m].crossings;
    if (crossings.size() != 1 || !crossings[0].pull_is_point) continue;
    const MuscleCrossing& tendon = crossings[0];
    ASSERT_EQ(hand.segments[tendon.pull_segment].joints, 0) << "the via point moves: think again";
    ++tendons;
    SCOPED_TRACE(hand.muscles[m].name);
    for (int trial = 0; trial < 20; ++trial) {
      const JointVector q = random_posture(hand, random);
      const auto length = [&](const JointVector& at) -> VectorXd {
        const HandPose pose = pose_at(hand, at);
        const Vector3d run = pose.segments[tendon.insertion_segment] * tendon.insertion_m -
                             pose.segments[tendon.pull_segment] * tendon.pull;
        return VectorXd::Constant(1, run.norm());
      };
      moment_arms(hand, pose_at(hand, q), H);
      const MatrixXd shortening = -tendon.share * gradient(q, length);
      for (const int i : tendon.joints) EXPECT_NEAR(H(i, static_cast<Index>(m)), shortening(0, i), kDifference);
    }
  }
  EXPECT_GT(tendons, 0);
}

// The other hand: what it does at the same angles is the mirror image of what the first one does, the torques of
// weights that are mirrored are the same, and so are moment arms. Mirrored twice it is the first one, to the last bit.
TEST_F(RandomPostures, AMirroredHandMovesAsTheMirrorImage) {
  const Hand other = mirrored(hand), again = mirrored(other);
  const Eigen::DiagonalMatrix<double, 3> M(1.0, 1.0, -1.0);
  const Vector3d gravity(3.0, -5.0, 8.0);
  MatrixXd H(kJoints, hand.muscles.size()), H_other = H;
  for (int trial = 0; trial < 20; ++trial) {
    SCOPED_TRACE(trial);
    const JointVector q = random_posture(hand, random);
    const HandPose one = pose_at(hand, q), two = pose_at(other, q);
    for (int k = 0; k < kFingers; ++k) {
      const Fingertip &tip = hand.fingertips[k], &tip_other = other.fingertips[k];
      const Vector3d c = one.distal(hand, k) * tip.centre_m, c_other = two.distal(other, k) * tip_other.centre_m;
      EXPECT_LE((M * c - c_other).norm(), 1e-15);
      EXPECT_LE(
          (M * (one.distal(hand, k).linear() * tip.normal) - two.distal(other, k).linear() * tip_other.normal).norm(),
          1e-14);
      EXPECT_GT(two.distal(other, k).linear().determinant(), 0.0);
    }
    EXPECT_LE((gravity_torques(hand, one, gravity) - gravity_torques(other, two, M * gravity)).norm(), 1e-15);
    moment_arms(hand, one, H);
    moment_arms(other, two, H_other);
    EXPECT_LE((H - H_other).cwiseAbs().maxCoeff(), 1e-15);
    EXPECT_EQ(pose_at(again, q).origin_m[kJoints - 1], one.origin_m[kJoints - 1]);
  }
}

// Every torque can be had from pulling muscles exactly if H has rank 12 and H f = 0 for some f > 0. A solution of
// H f = -H 1, f >= 0 gives it: f + 1. A singular value of 1 mm is a tenth of a usual moment arm.
TEST_F(RandomPostures, MusclesSpanEveryTorque) {
  const Index muscles = std::ssize(hand.muscles);
  MatrixXd H(kJoints, muscles);
  VectorXd f(muscles);
  for (int trial = 0; trial < 3000; ++trial) {
    SCOPED_TRACE(trial);
    moment_arms(hand, pose_at(hand, random_posture(hand, random)), H);
    EXPECT_GT(H.jacobiSvd().singularValues()[kJoints - 1], 1e-3);
    const VectorXd tau = -H.rowwise().sum();
    const MuscleReport report = solve_muscle_forces({H, tau}, f);
    ASSERT_EQ(report.status, MuscleStatus::kOptimal);
    EXPECT_GE(f.minCoeff(), 0.0);
    EXPECT_LE((H * (f + VectorXd::Ones(muscles))).cwiseAbs().maxCoeff(), 1e-12);
  }
}

}  // namespace
}  // namespace thenar::hand_test
