// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/tendon_route.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

bool moves(const Hand& hand, int joint, const Segment& segment) {
  const Fingertip& tip = hand.fingertips[segment.finger];
  return joint >= tip.first_joint && joint < tip.first_joint + segment.joints;
}

/// Adds the arms of a straight piece: it shortens by u . (the speed of its ends towards each other), u from p to q.
void add_straight(const Hand& hand, const HandPose& pose, int p_segment, const Vector3d& p, int q_segment,
                  const Vector3d& q, JointVector& arms) {
  if (p_segment == q_segment) return;
  const Vector3d u = (q - p).stableNormalized();
  for (const int j : joints_between(hand, p_segment, q_segment)) {
    const bool moves_p = moves(hand, j, hand.segments[p_segment]);
    const Vector3d& moved = moves_p ? p : q;
    const double sign = moves_p ? 1.0 : -1.0;
    arms[j] += sign * pose.axis[j].cross(moved - pose.origin_m[j]).dot(u);
  }
}

}  // namespace

std::vector<int> joints_between(const Hand& hand, int one_segment, int other_segment) {
  std::vector<int> joints;
  for (int j = 0; j < static_cast<int>(hand.joints.size()); ++j) {
    if (moves(hand, j, hand.segments[one_segment]) != moves(hand, j, hand.segments[other_segment])) joints.push_back(j);
  }
  return joints;
}

JointVector span_arms(const Hand& hand, const HandPose& pose, const RouteSpan& span) {
  JointVector arms = hand.at_zero();
  const Vector3d from = pose.segments[span.from.segment] * span.from.p_S;
  const Vector3d to = pose.segments[span.to.segment] * span.to.p_S;
  if (span.wrap) {
    const RouteWrap& wrapped = *span.wrap;
    const Isometry3d X_WG = pose.segments[wrapped.segment] * wrapped.X_SG, X_GW = X_WG.inverse();
    std::optional<Vector3d> side;
    if (wrapped.side) side = X_GW * (pose.segments[wrapped.side->segment] * wrapped.side->p_S);
    if (const auto touch = wrap(wrapped.surface, X_GW * from, X_GW * to, side)) {
      // The length on the surface only changes as the points on it move, which do so along the string.
      add_straight(hand, pose, span.from.segment, from, wrapped.segment, X_WG * (*touch)[0], arms);
      add_straight(hand, pose, wrapped.segment, X_WG * (*touch)[1], span.to.segment, to, arms);
      return span.share * arms;
    }
  }
  add_straight(hand, pose, span.from.segment, from, span.to.segment, to, arms);
  return span.share * arms;
}

}  // namespace thenar
