// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/pulp_guess.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace thenar {

using Eigen::Vector3d;

void guess_normals(Hand& hand, std::vector<std::string>& notes) {
  JointVector q = hand.at_zero();
  for (std::size_t j = 0; j < hand.joints.size(); ++j) {
    q[static_cast<Eigen::Index>(j)] = 0.5 * (hand.joints[j].lower_rad + hand.joints[j].upper_rad);
  }
  HandPose pose;
  forward_kinematics(hand, q, pose);
  std::vector<Vector3d> centres;
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < hand.fingers(); ++k) {
    centres.push_back(pose.distal(hand, k) * hand.fingertips[k].centre_m);
    sum += centres.back();
  }
  for (int k = 0; k < hand.fingers(); ++k) {
    Fingertip& tip = hand.fingertips[k];
    if (!tip.normal.isZero()) continue;
    // A finger faces the first one, the thumb, and that faces the others.
    const Vector3d others = hand.fingers() == 1 ? Vector3d::Zero()
                            : k > 0             ? centres[0]
                                                : Vector3d((sum - centres[0]) / (hand.fingers() - 1.0));
    const Vector3d towards = pose.distal(hand, k).linear().transpose() * (others - centres[k]);
    // y of the last segment lies across its bone, in the plane in which its joint turns it.
    constexpr double kTilt = 20.0 * std::numbers::pi / 180.0;
    const double side = towards.y() < 0.0 ? -1.0 : 1.0;
    tip.normal = Vector3d(std::sin(kTilt), side * std::cos(kTilt), 0.0);
    const bool is_clear = std::abs(towards.y()) > 0.3 * towards.norm();
    notes.push_back(fmt::format("the {}'s pulp faces {}, a guess{}", tip.finger,
                                hand.fingers() == 1 ? "the hand's origin"
                                : k == 0            ? "the other fingertips"
                                                    : "the first finger",
                                is_clear ? "" : " that may be wrong: name its direction in --tips"));
  }
}

}  // namespace thenar
