#include "engine/grasp/coupled_joints.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace thenar {

using Eigen::AngleAxisd;
using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

namespace {

int finger_of(const Hand& hand, int joint) {
  const auto has = [&](const Fingertip& tip) { return tip.has_joint(joint); };
  return static_cast<int>(std::find_if(hand.fingertips.begin(), hand.fingertips.end(), has) - hand.fingertips.begin());
}

/// Cuts the leader's range to what keeps its follower within its own.
void keep_limits(const Joint& follower, const Coupling& coupling, Joint& leader) {
  const double one = (follower.lower_rad - coupling.offset_rad) / coupling.ratio;
  const double other = (follower.upper_rad - coupling.offset_rad) / coupling.ratio;
  leader.lower_rad = std::max(leader.lower_rad, std::min(one, other));
  leader.upper_rad = std::min(leader.upper_rad, std::max(one, other));
}

/// Which joint of `from` is which of the hand that is made of it: followers count on from the joints.
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

void coupled_kinematics(const Hand& hand, const JointVector& q, int finger, FingerChain& chain, HandPose& pose) {
  const Fingertip& tip = hand.fingertips[finger];
  int at = 0, next = tip.first_follower;
  const auto turn = [&](const Joint& joint, std::size_t place, double angle) {
    pose.origin_m[place] = chain[at] * joint.origin_m;
    pose.axis[place] = chain[at].linear() * joint.axis;
    const Translation3d to_joint(joint.origin_m);
    chain[at + 1] = chain[at] * to_joint * AngleAxisd(angle, joint.axis) * to_joint.inverse();
    ++at;
  };
  chain[0].setIdentity();
  for (int j = 0; j < tip.joints; ++j) {
    turn(hand.joints[tip.first_joint + j], tip.first_joint + j, q[tip.first_joint + j]);
    for (; next < tip.first_follower + tip.followers && hand.followers[next].after == j + 1; ++next) {
      const Follower& follower = hand.followers[next];
      turn(follower.joint, hand.joints.size() + next, follower.angle(q));
    }
  }
}

FingerJacobian coupled_jacobian(const Hand& hand, const HandPose& pose, int finger, int followers,
                                const Vector3d& point_m) {
  const Fingertip& tip = hand.fingertips[finger];
  FingerJacobian J = FingerJacobian::Zero(3, std::max(4, tip.joints));
  const auto lever = [&](std::size_t place) { return pose.axis[place].cross(point_m - pose.origin_m[place]); };
  for (int j = 0; j < tip.joints; ++j) J.col(j) = lever(tip.first_joint + j);
  for (int i = tip.first_follower; i < tip.first_follower + followers; ++i) {
    const Follower& follower = hand.followers[i];
    J.col(follower.leader - tip.first_joint) += follower.ratio * lever(hand.joints.size() + i);
  }
  return J;
}

void add_coupled_arms(const Hand& hand, const HandPose& pose, const MuscleCrossing& crossing, const Vector3d& M,
                      const Vector3d& D, Eigen::Ref<Eigen::VectorXd> H_m) {
  for (const int i : crossing.joints) {
    if (i < std::ssize(hand.joints)) continue;
    const Follower& follower = hand.followers[i - hand.joints.size()];
    const double arm_m = crossing.share * (M - pose.origin_m[i]).cross(D).dot(pose.axis[i]);
    H_m[follower.leader] += follower.ratio * arm_m;
  }
}

FingerJacobian coupled_axes(const Hand& hand, const HandPose& pose, int finger) {
  const Fingertip& tip = hand.fingertips[finger];
  FingerJacobian axes = FingerJacobian::Zero(3, std::max(4, tip.joints));
  for (int j = 0; j < tip.joints; ++j) axes.col(j) = pose.axis[tip.first_joint + j];
  for (int i = tip.first_follower; i < tip.first_follower + tip.followers; ++i) {
    const Follower& follower = hand.followers[i];
    axes.col(follower.leader - tip.first_joint) += follower.ratio * pose.axis[hand.joints.size() + i];
  }
  return axes;
}

}  // namespace thenar
