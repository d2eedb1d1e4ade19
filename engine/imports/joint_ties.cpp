// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/joint_ties.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>
#include <utility>

#include "engine/formats/text.h"
#include "engine/scenes/config.h"

namespace thenar {

namespace {

constexpr double kLeastRatio = 0.01, kMostRatio = 100.0;  // Beyond these a hand file's digits are insufficient.

[[noreturn]] void refuse_tie(const TreeCoupling& tie, const std::string& what) {
  throw ConfigError({{printable(tie.place), printable(tie.what), printable(what)}});
}

/// The angle of a joint: ratio times that of its root, plus an offset. A root is its own root.
struct Tied {
  int root = 0;
  double ratio = 1.0, offset_rad = 0.0;
  const TreeCoupling* by = nullptr;
};

int finger_of(const Hand& hand, int joint) {
  int k = 0;
  while (!hand.fingertips[k].has_joint(joint)) ++k;
  return k;
}

/// Joins the follower's group to the leader's: q_follower = ratio q_leader + offset.
void join(const TreeCoupling& tie, int follower, int leader, std::vector<Tied>& joints) {
  const Tied a = joints[follower], b = joints[leader];
  // The follower's root x is then ratio_x times the leader's root, and an offset.
  const double ratio_x = tie.line->ratio * b.ratio / a.ratio;
  const double offset_x = (tie.line->ratio * b.offset_rad + tie.line->offset_rad - a.offset_rad) / a.ratio;
  for (Tied& joint : joints) {
    if (joint.root != a.root) continue;
    joint.offset_rad += joint.ratio * offset_x;
    joint.ratio *= ratio_x;
    joint.root = b.root;
    joint.by = &tie;
  }
}

/// Makes each joint that is not the first of its group follow the first.
std::vector<std::pair<Coupling, const TreeCoupling*>> led_by_first(const std::vector<Tied>& joints) {
  std::vector<std::pair<Coupling, const TreeCoupling*>> couplings;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    std::size_t first = 0;
    while (joints[first].root != joints[i].root) ++first;
    if (first == i) continue;
    const double ratio = joints[i].ratio / joints[first].ratio;
    couplings.emplace_back(Coupling{static_cast<int>(i), static_cast<int>(first), ratio,
                                    joints[i].offset_rad - ratio * joints[first].offset_rad},
                           joints[i].by != nullptr ? joints[i].by : joints[first].by);
  }
  return couplings;
}

}  // namespace

BodyTree limited_by_ties(BodyTree tree) {
  std::map<std::string_view, TreeJoint*> hinges;
  for (TreeBody& body : tree.bodies) {
    for (TreeJoint& joint : body.joints) {
      if (joint.kind == TreeJointKind::kHinge) hinges.emplace(joint.name, &joint);
    }
  }
  const auto hinge = [&](const std::string& name) {
    const auto found = hinges.find(name);
    return found == hinges.end() ? nullptr : found->second;
  };
  const auto line = [](const std::array<double, 2>& range, double ratio, double offset_rad) {
    const double a = ratio * range[0] + offset_rad, b = ratio * range[1] + offset_rad;
    return std::array{std::min(a, b), std::max(a, b)};
  };
  // A chain of ties in a finger is no longer than its joints.
  for (int pass = 0; pass < kMaxFingerJoints; ++pass) {
    for (const TreeCoupling& tie : tree.couplings) {
      if (!tie.line || tie.joints.size() != 2 || tie.line->ratio == 0.0) continue;
      TreeJoint* const follower = hinge(tie.joints[0]);
      TreeJoint* const leader = hinge(tie.joints[1]);
      if (follower == nullptr || leader == nullptr) continue;
      const double ratio = tie.line->ratio, offset_rad = tie.line->offset_rad;
      if (!follower->range && leader->range) {
        follower->range = line(*leader->range, ratio, offset_rad);
      } else if (follower->range && !leader->range) {
        leader->range = line(*follower->range, 1.0 / ratio, -offset_rad / ratio);
      }
    }
  }
  return tree;
}

Hand tied(Hand hand, const BodyTree& tree, const FingerChains& chains, std::vector<std::string>& notes) {
  std::vector<Tied> joints(hand.joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) joints[i].root = static_cast<int>(i);
  for (const int index : chains.ties) {
    const TreeCoupling& tie = tree.couplings[index];
    const int follower = index_of_name(hand.joints, tie.joints[0]), leader = index_of_name(hand.joints, tie.joints[1]);
    const Fingertip &one = hand.fingertips[finger_of(hand, follower)],
                    &other = hand.fingertips[finger_of(hand, leader)];
    if (&one != &other) {
      refuse_tie(tie, fmt::format("couples {} of the {} to {} of the {}: a joint follows one of its own finger "
                                  "(--lock {} locks it, and --uncouple leaves the coupling out)",
                                  tie.joints[0], one.finger, tie.joints[1], other.finger, tie.joints[0]));
    }
    if (joints[follower].root == joints[leader].root) {
      refuse_tie(tie, fmt::format("couples {} to {}, which are coupled already", tie.joints[0], tie.joints[1]));
    }
    join(tie, follower, leader, joints);
  }
  std::vector<Coupling> couplings;
  for (const auto& [coupling, tie] : led_by_first(joints)) {
    if (const double size = std::abs(coupling.ratio); !(size >= kLeastRatio && size <= kMostRatio)) {
      refuse_tie(*tie, fmt::format("would turn {} {:g} times as far as {}", hand.joints[coupling.joint].name,
                                   coupling.ratio, hand.joints[coupling.leader].name));
    }
    couplings.push_back(coupling);
    if (const std::string fault = coupling_fault(hand, couplings); !fault.empty()) refuse_tie(*tie, fault);
    notes.push_back(fmt::format("joint '{}' follows '{}': {:g} times its angle{}", hand.joints[coupling.joint].name,
                                hand.joints[coupling.leader].name, coupling.ratio,
                                coupling.offset_rad == 0.0
                                    ? ""
                                    : fmt::format(" and {:g} deg", coupling.offset_rad * 180.0 / std::numbers::pi)));
  }
  return coupled(std::move(hand), couplings);
}

}  // namespace thenar
