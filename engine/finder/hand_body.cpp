// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/hand_body.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "engine/grasp/frame.h"
#include "engine/grasp/pulp_touch.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

constexpr double kThickness = 0.7;      // Radius of a finger's bones over its pulp's.
constexpr double kTipThickness = 0.45;  // Likewise near the pulp, which is indented there.
constexpr double kBone = 0.5;           // Likewise of the rigid bones themselves.

/// Adds spheres between two points, less than their radii apart.
void add_bar(BodyPoint point, const Vector3d& from_m, const Vector3d& to_m, std::vector<BodyPoint>& body) {
  const int parts = std::max(1, static_cast<int>(std::ceil((to_m - from_m).norm() / (1.6 * point.clearance_m))));
  for (int i = 0; i <= parts; ++i) {
    point.p_S = from_m + (to_m - from_m) * i / parts;
    body.push_back(point);
  }
}

}  // namespace

std::vector<BodyPoint> hand_body(const Hand& hand) {
  std::vector<BodyPoint> body;
  double palm_m = 0.0;
  for (const Fingertip& tip : hand.fingertips) palm_m = std::max(palm_m, tip.radius_m);
  for (int s = 0; s < static_cast<int>(hand.segments.size()); ++s) {
    const Segment& segment = hand.segments[s];
    if (segment.joints == 0) continue;
    const Fingertip& tip = hand.fingertips[segment.finger];
    const BodyPoint point{s, segment.finger, segment.joints, Vector3d::Zero(), kThickness * tip.radius_m};
    if (s != tip.segment) {
      add_bar(point, Vector3d::Zero(), {segment.length_m, 0.0, 0.0}, body);
      continue;
    }
    // Up to where the pulp begins.
    const double reach_m = tip.centre_m.norm();
    const double along_m = extent_m(tip, tip.centre_m.normalized());
    const Vector3d to_m = tip.centre_m * std::max(0.0, 1.0 - 0.6 * along_m / std::max(reach_m, 1e-9));
    BodyPoint end = point;
    end.clearance_m = kTipThickness * tip.radius_m;
    add_bar(end, Vector3d::Zero(), to_m, body);
  }
  std::vector<Vector3d> roots_m;
  for (const Fingertip& tip : hand.fingertips) roots_m.push_back(hand.joints[tip.first_joint].origin_m);
  const BodyPoint palm{-1, 0, 0, Vector3d::Zero(), palm_m};
  for (std::size_t k = 0; k < roots_m.size(); ++k) {
    add_bar(palm, Vector3d::Zero(), roots_m[k], body);
    if (k > 0) add_bar(palm, roots_m[k - 1], roots_m[k], body);
  }
  return body;
}

Bones bones_of(const Hand& hand, const std::vector<BodyPoint>& body) {
  Bones bones;
  for (const BodyPoint& point : body) {
    if (point.segment >= 0) bones.points.push_back(point);
  }
  const std::size_t pulps = bones.points.size();
  for (int k = 0; k < hand.fingers(); ++k) {
    const Fingertip& tip = hand.fingertips[k];
    bones.points.push_back({tip.segment, k, tip.joints, tip.centre_m, 0.0});
  }
  for (BodyPoint& point : bones.points) point.clearance_m = kBone * hand.fingertips[point.finger].radius_m;
  JointVector q = hand.at_zero();
  for (Eigen::Index i = 0; i < q.size(); ++i)
    q[i] = std::clamp(0.0, hand.joints[i].lower_rad, hand.joints[i].upper_rad);
  HandPose open;
  forward_kinematics(hand, q, open);
  for (std::size_t a = 0; a < bones.points.size(); ++a) {
    for (std::size_t b = 0; b < std::min(a, pulps); ++b) {
      const BodyPoint &one = bones.points[a], &other = bones.points[b];
      if (one.finger == other.finger) continue;
      const double open_m = (one.in(open)-other.in(open)).norm();
      bones.pairs.push_back(
          {static_cast<int>(a), static_cast<int>(b), std::min(one.clearance_m + other.clearance_m, open_m)});
    }
  }
  return bones;
}

BoneOverlap overlap_of(const Bones& bones, const HandPose& pose) {
  std::vector<Vector3d> places_m;
  for (const BodyPoint& point : bones.points) places_m.push_back(point.in(pose));
  BoneOverlap most;
  for (const BonePair& pair : bones.pairs) {
    const double least_m = pair.least_m - most.depth_m;
    const double square = (places_m[pair.a] - places_m[pair.b]).squaredNorm();
    if (least_m <= 0.0 || square >= least_m * least_m) continue;
    most = {pair.least_m - std::sqrt(square), bones.points[pair.a].finger, bones.points[pair.b].finger};
  }
  return most;
}

PulpPose pulp_pose(const Hand& hand, const HandPose& pose, int finger) {
  const Fingertip& tip = hand.fingertips[finger];
  const Eigen::Isometry3d& X_WF = pose.distal(hand, finger);
  PulpPose pulp{X_WF * tip.centre_m, X_WF.linear() * tip.normal, {}, {}};
  pulp.J_centre = finger_jacobian(hand, pose, finger, pulp.centre_m);
  pulp.J_normal = FingerJacobian::Zero(3, pulp.J_centre.cols());
  const FingerJacobian axes = turning_axes(hand, pose, finger);
  for (int j = 0; j < tip.joints; ++j) pulp.J_normal.col(j) = Vector3d(axes.col(j)).cross(pulp.normal);
  return pulp;
}

double touching_m(const Hand& hand, const HandPose& pose, int one, int other, const Vector3d& d) {
  const auto reach_m = [&](int k) {
    return extent_m(hand.fingertips[k], pose.distal(hand, k).linear().transpose() * d);
  };
  return reach_m(one) + reach_m(other);
}

double dexterity(const Hand& hand, const HandPose& pose, int finger, const Vector3d& x_m) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> values;
  values.computeDirect(squared(finger_jacobian(hand, pose, finger, x_m)), Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, values.eigenvalues()[0]) / std::max(1e-300, values.eigenvalues()[2]));
}

Hand hand_of(const Hand& hand, std::vector<int> fingers) {
  std::sort(fingers.begin(), fingers.end());
  Hand part;
  part.mirrored = hand.mirrored;
  std::vector<int> finger_of(hand.fingertips.size(), -1), joint_of(hand.joints.size() + hand.followers.size(), -1);
  for (const int k : fingers) {
    finger_of[k] = part.fingers();
    Fingertip tip = hand.fingertips[k];
    const int first = tip.first_joint;
    tip.first_joint = static_cast<int>(part.joints.size());
    for (int j = first; j < first + tip.joints; ++j) {
      joint_of[j] = static_cast<int>(part.joints.size());
      part.joints.push_back(hand.joints[j]);
    }
    tip.first_follower = static_cast<int>(part.followers.size());
    for (int i = 0; i < tip.followers; ++i) {
      part.followers.push_back(hand.followers[hand.fingertips[k].first_follower + i]);
      part.followers.back().leader = joint_of[part.followers.back().leader];
    }
    part.fingertips.push_back(tip);
  }
  for (const int k : fingers) {
    for (int i = 0; i < hand.fingertips[k].followers; ++i) {
      joint_of[hand.joints.size() + hand.fingertips[k].first_follower + i] =
          static_cast<int>(part.joints.size()) + part.fingertips[finger_of[k]].first_follower + i;
    }
  }
  // The palm, which no joint moves, belongs to all.
  std::vector<int> segment_of(hand.segments.size(), -1);
  for (std::size_t s = 0; s < hand.segments.size(); ++s) {
    Segment segment = hand.segments[s];
    segment.finger = segment.joints == 0 ? 0 : finger_of[segment.finger];
    if (segment.finger < 0) continue;
    segment_of[s] = static_cast<int>(part.segments.size());
    part.segments.push_back(segment);
  }
  for (Fingertip& tip : part.fingertips) tip.segment = segment_of[tip.segment];
  for (Muscle muscle : hand.muscles) {
    std::erase_if(muscle.crossings, [&](const MuscleCrossing& crossing) {
      return joint_of[crossing.joints.front()] < 0 || segment_of[crossing.insertion_segment] < 0 ||
             segment_of[crossing.pull_segment] < 0;
    });
    for (MuscleCrossing& crossing : muscle.crossings) {
      std::erase_if(crossing.joints, [&](int joint) { return joint_of[joint] < 0; });
      for (int& joint : crossing.joints) joint = joint_of[joint];
      crossing.insertion_segment = segment_of[crossing.insertion_segment];
      crossing.pull_segment = segment_of[crossing.pull_segment];
    }
    if (!muscle.crossings.empty()) part.muscles.push_back(muscle);
  }
  return part;
}

}  // namespace thenar
