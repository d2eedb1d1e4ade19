// SPDX-License-Identifier: Apache-2.0
#include "app/studies/hand_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "engine/capacity/opposition.h"
#include "engine/formats/text.h"
#include "engine/hand/muscles.h"

namespace thenar::app {

using Eigen::Index;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::string pulp_in_words(const Fingertip& tip) {
  if (!tip.shape) return fmt::format(" of {:.1f} mm radius", 1e3 * tip.radius_m);
  const Eigen::Vector3d mm = 1e3 * tip.shape->half_m;
  if (tip.shape->form == PulpShape::Form::kCapsule) {
    return fmt::format(", a capsule {:.1f} mm long and {:.1f} mm thick", 2.0 * (mm[0] + mm[1]), 2.0 * mm[1]);
  }
  return fmt::format(", an ellipsoid with semi-axes of {:.1f}, {:.1f} and {:.1f} mm", mm[0], mm[1], mm[2]);
}

std::string finger_text(const Hand& hand, const Fingertip& tip) {
  double reach_m = 0.0;
  for (const Segment& segment : hand.segments) {
    if (segment.joints > 0 && hand.fingertips[segment.finger].first_joint == tip.first_joint)
      reach_m += segment.length_m;
  }
  std::string text = fmt::format("\n{}: {}, {:.0f} mm from its first joint to its pulp{}\n", tip.finger,
                                 counted(tip.joints, "joint"), 1e3 * reach_m, pulp_in_words(tip));
  for (int j = tip.first_joint; j < tip.first_joint + tip.joints; ++j) {
    const Joint& joint = hand.joints[j];
    text += fmt::format("  {:<24}{:>7.1f} .. {:.1f} deg\n", joint.name, joint.lower_rad / kDegree,
                        joint.upper_rad / kDegree);
  }
  for (int i = tip.first_follower; i < tip.first_follower + tip.followers; ++i) {
    const Follower& follower = hand.followers[i];
    text += fmt::format("  {:<24} follows {}, {:.3g} times its angle", follower.joint.name,
                        hand.joints[follower.leader].name, follower.ratio);
    if (follower.offset_rad != 0.0) text += fmt::format(" and {:.1f} deg", follower.offset_rad / kDegree);
    text += '\n';
  }
  return text;
}

/// The moment arms while all joints are in the middle of their ranges.
std::string muscles_text(const Hand& hand) {
  if (hand.muscles.empty()) return "\nno muscles: torques drive the joints\n";
  JointVector q = hand.at_zero();
  for (std::size_t j = 0; j < hand.joints.size(); ++j) {
    q[static_cast<Index>(j)] = 0.5 * (hand.joints[j].lower_rad + hand.joints[j].upper_rad);
  }
  HandPose pose;
  forward_kinematics(hand, q, pose);
  Eigen::MatrixXd H(std::ssize(hand.joints), std::ssize(hand.muscles));
  moment_arms(hand, pose, H);
  std::string text = "\nmuscles, their greatest force, and moment arms in the middle of the joints' ranges, mm\n";
  for (std::size_t m = 0; m < hand.muscles.size(); ++m) {
    text += fmt::format("  {:<12}{:>6.0f} N  ", hand.muscles[m].name, hand.muscles[m].max_force_N);
    for (Index j = 0; j < H.rows(); ++j) {
      const double arm_mm = 1e3 * H(j, static_cast<Index>(m));
      if (std::abs(arm_mm) >= 0.05) text += fmt::format("  {} {:.1f}", hand.joints[j].name, arm_mm);
    }
    text += '\n';
  }
  return text;
}

std::string opposition_text(const Hand& hand, const std::vector<FacingFingers>& pairs) {
  std::string text = "\nfingers whose pulps can face each other, and the width between them, mm\n";
  for (const FacingFingers& pair : pairs) {
    text += fmt::format("  {:<24}{:>5.0f} .. {:.0f}\n",
                        hand.fingertips[pair.one].finger + " and " + hand.fingertips[pair.other].finger,
                        std::floor(1e3 * pair.least_m), 1e3 * pair.most_m);
  }
  if (pairs.empty()) text += "  none\n";
  return text;
}

std::vector<std::string> hand_warnings(const Hand& hand, const std::vector<FacingFingers>& pairs) {
  std::vector<std::string> warnings;
  const std::string& first = hand.fingertips.front().finger;
  const bool first_opposes = std::ranges::any_of(pairs, [](const FacingFingers& pair) { return pair.one == 0; });
  if (hand.fingers() == 1) {
    warnings.emplace_back("it has one finger, which can press but hold nothing");
  } else if (pairs.empty()) {
    warnings.emplace_back("no two pulps can face each other: it can pinch nothing");
  } else if (!first_opposes) {
    warnings.push_back(fmt::format("the {}, its first finger, can face no other", first));
  }
  std::int64_t weightless = 0;
  for (const Segment& segment : hand.segments) weightless += segment.joints > 0 && segment.mass_kg == 0.0 ? 1 : 0;
  if (weightless > 0) warnings.push_back(counted(weightless, "segment") + " without mass: gravity does not pull there");
  return warnings;
}

}  // namespace

std::string joint_count(const Hand& hand) {
  const std::string own = counted(std::ssize(hand.joints), "joint");
  return hand.followers.empty() ? own : fmt::format("{} and {} that follow", own, hand.followers.size());
}

std::string hand_list(const Hand& hand, const std::string& name) {
  std::string text = fmt::format("{}: {}, {}, {}\n", name, counted(hand.fingers(), "finger"), joint_count(hand),
                                 counted(std::ssize(hand.muscles), "muscle"));
  for (const Fingertip& tip : hand.fingertips) text += finger_text(hand, tip);
  text += muscles_text(hand);
  const std::vector<FacingFingers> pairs = find_oppositions(hand);
  text += opposition_text(hand, pairs);
  const std::vector<std::string> warnings = hand_warnings(hand, pairs);
  if (!warnings.empty()) text += "\nwarnings\n";
  for (const std::string& warning : warnings) text += fmt::format("  {}\n", warning);
  return text;
}

}  // namespace thenar::app
