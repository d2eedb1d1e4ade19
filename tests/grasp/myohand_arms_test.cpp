// SPDX-License-Identifier: Apache-2.0
// Moment arms of the human hands beside those of MyoHand, by which their tendons were laid: over the range of each
// joint, and of both joints of a knuckle or of the thumb's root together.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/hand/hand.h"
#include "engine/hand/muscles.h"
#include "engine/scenes/hand_file.h"
#include "tests/support/json_eigen.h"
#include "tests/support/scenes.h"

namespace thenar::myohand_arms_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::json;

Index joint_of(const Hand& hand, const std::string& name) {
  return std::ranges::find(hand.joints, name, &Joint::name) - hand.joints.begin();
}

/// A muscle that parts among fingers pulls each with a share of its force; MyoHand's is one for each finger.
double share_of(const Muscle& muscle, Index joint) {
  for (const MuscleCrossing& crossing : muscle.crossings) {
    if (std::ranges::find(crossing.joints, joint) != crossing.joints.end()) return crossing.share;
  }
  return 1.0;
}

/// How far a muscle's arms of a joint are from those of MyoHand, in mm: a column for each angle of the joint, a row for
/// each of the other that turns with it.
MatrixXd difference_mm(const Hand& hand, const json& joint, const json& muscle) {
  const MatrixXd theirs_mm = matrix_of(muscle.at("arms_mm"));
  const VectorXd angles_rad = vector_of(joint.at("angles_rad"));
  const Index i = joint_of(hand, joint.at("joint"));
  const Index m =
      std::ranges::find(hand.muscles, muscle.at("muscle").get<std::string>(), &Muscle::name) - hand.muscles.begin();
  MatrixXd H(std::ssize(hand.joints), std::ssize(hand.muscles)), away_mm(theirs_mm.rows(), theirs_mm.cols());
  HandPose pose;
  for (Index row = 0; row < theirs_mm.rows(); ++row) {
    for (Index column = 0; column < theirs_mm.cols(); ++column) {
      JointVector q = hand.at_zero();
      q[i] = angles_rad[column];
      if (joint.contains("other")) q[joint_of(hand, joint.at("other"))] = joint.at("other_angles_rad")[row];
      forward_kinematics(hand, q, pose);
      moment_arms(hand, pose, H);
      away_mm(row, column) = 1e3 * H(i, m) / share_of(hand.muscles[m], i) - theirs_mm(row, column);
    }
  }
  return away_mm;
}

// The file says how far each was when the tendons were laid. It has two digits of each number: an arm, its difference
// and their mean may be off by 0.005 mm each.
constexpr double kPrinted_mm = 0.015;

TEST(MyoHandArms, AreNoFartherThanTheTendonsWereLaid) {
  const json hands = read_json(THENAR_TEST_DATA "/hands/myohand_arms.json").at("hands");
  ASSERT_EQ(hands.size(), 2U);
  for (const json& part : hands) {
    const Hand hand = load_hand(config_file(part.at("hand")));
    for (const json& joint : part.at("joints")) {
      for (const json& muscle : joint.at("muscles")) {
        SCOPED_TRACE(muscle.at("muscle").get<std::string>() + " at " + joint.at("joint").get<std::string>());
        const MatrixXd away_mm = difference_mm(hand, joint, muscle);
        EXPECT_LE(std::sqrt(away_mm.squaredNorm() / static_cast<double>(away_mm.size())),
                  muscle.at("off_rms_mm").get<double>() + kPrinted_mm);
        EXPECT_LE(away_mm.cwiseAbs().maxCoeff(), muscle.at("off_most_mm").get<double>() + kPrinted_mm);
      }
    }
  }
}

// Ring and little finger of the five-fingered hand have MyoHand's own tendons where these run straight.
TEST(MyoHandArms, AreTheirsWhereTheTendonsAreTheirs) {
  const json hands = read_json(THENAR_TEST_DATA "/hands/myohand_arms.json").at("hands");
  const Hand hand = load_hand(config_file("hands/human5"));
  int flexors = 0;
  for (const json& joint : hands.back().at("joints")) {
    for (const json& muscle : joint.at("muscles")) {
      const std::string name = muscle.at("muscle");
      if (!name.starts_with("FD")) continue;
      EXPECT_LE(difference_mm(hand, joint, muscle).cwiseAbs().maxCoeff(), kPrinted_mm) << name << joint.at("joint");
      ++flexors;
    }
  }
  EXPECT_EQ(flexors, 14);  // Of two fingers: two at three joints, and the deep one at the last.
}

}  // namespace
}  // namespace thenar::myohand_arms_test
