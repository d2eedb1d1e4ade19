// SPDX-License-Identifier: Apache-2.0
#include "engine/hand/coupled_joints.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace thenar {

namespace {

int finger_of(const Hand& hand, int joint) {
  const auto has = [&](const Fingertip& tip) { return tip.has_joint(joint); };
  return static_cast<int>(std::find_if(hand.fingertips.begin(), hand.fingertips.end(), has) - hand.fingertips.begin());
}

/// Restricts the leader's range to keep its follower within its own.
void keep_limits(const Joint& follower, const Coupling& coupling, Joint& leader) {
  const double one = (follower.lower_rad - coupling.offset_rad) / coupling.ratio;
  const double other = (follower.upper_rad - coupling.offset_rad) / coupling.ratio;
  leader.lower_rad = std::max(leader.lower_rad, std::min(one, other));
  leader.upper_rad = std::min(leader.upper_rad, std::max(one, other));
}

/// Maps joints of `from` to those of the hand made of it; followers are numbered after the joints.
std::vector<int> share_out(const Hand& from, std::span<const Coupling> couplings, Hand& hand) {
  std::vector<int> place(from.joints.size()), follower(from.joints.size(), -1);
  hand.joints.clear();
  for (Fingertip& tip : hand.fingertips) {
    const int first = tip.first_joint, end = first + tip.joints;
    tip.first_joint = static_cast<int>(hand.joints.size());
    tip.first_follower = static_cast<int>(hand.followers.size());
    for (int j = first; j < end; ++j) {
      const auto coupling = std::ranges::find(couplings, j, &Coupling::joint);
      if (coupling == couplings.end()) {
        place[j] = static_cast<int>(hand.joints.size());
        hand.joints.push_back(from.joints[j]);
        continue;
      }
      follower[j] = static_cast<int>(hand.followers.size());
      const int after = static_cast<int>(hand.joints.size()) - tip.first_joint;
      hand.followers.push_back({from.joints[j], place[coupling->leader], coupling->ratio, coupling->offset_rad, after});
      Joint& leader = hand.joints[place[coupling->leader]];
      keep_limits(from.joints[j], *coupling, leader);
      leader.drag += coupling->ratio * coupling->ratio;
    }
    tip.joints = static_cast<int>(hand.joints.size()) - tip.first_joint;
    tip.followers = static_cast<int>(hand.followers.size()) - tip.first_follower;
  }
  for (std::size_t j = 0; j < place.size(); ++j) {
    if (follower[j] >= 0) place[j] = static_cast<int>(hand.joints.size()) + follower[j];
  }
  return place;
}

}  // namespace

std::string coupling_fault(const Hand& hand, std::span<const Coupling> couplings) {
  const Coupling& last = couplings.back();
  const std::string leader = "'" + hand.joints[last.leader].name + "'";
  if (finger_of(hand, last.joint) != finger_of(hand, last.leader)) {
    return leader + " is a joint of another finger: a joint follows one of its own";
  }
  if (last.leader >= last.joint) return leader + " is no nearer to the palm: let that joint follow this one";
  for (const Coupling& other : couplings) {
    if (other.joint == last.leader) return leader + " follows a joint itself: name that one";
  }
  if (last.ratio == 0.0) return "with a ratio of zero it would not turn: leave the joint out";
  Joint range = hand.joints[last.leader];
  for (const Coupling& other : couplings) {
    if (other.leader == last.leader) keep_limits(hand.joints[other.joint], other, range);
  }
  if (range.lower_rad < range.upper_rad) return {};
  return "no range of " + leader + " keeps what follows it within its limits";
}

Hand coupled(Hand hand, std::span<const Coupling> couplings) {
  if (couplings.empty()) return hand;
  const Hand from = hand;
  const std::vector<int> place = share_out(from, couplings, hand);
  for (Segment& segment : hand.segments) {
    const int first = from.fingertips[segment.finger].first_joint, moved = segment.joints;
    for (int j = first; j < first + moved; ++j) {
      if (place[j] < std::ssize(hand.joints)) continue;
      --segment.joints;
      ++segment.followers;
    }
  }
  for (Muscle& muscle : hand.muscles) {
    for (MuscleCrossing& crossing : muscle.crossings) {
      for (int& joint : crossing.joints) joint = place[joint];
    }
  }
  return hand;
}

}  // namespace thenar
