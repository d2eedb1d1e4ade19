// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/tree_segments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

namespace {

/// Returns the axis that defines z: the first perpendicular one of the segment's own joints, then of those behind it.
Vector3d across(const Hand& hand, const Segment& segment, const Vector3d& x, int own_joints) {
  constexpr double kAlong = 0.7;  // As a cosine.
  const Fingertip& tip = hand.fingertips[segment.finger];
  for (int j = tip.first_joint + segment.joints - own_joints; j < tip.first_joint + tip.joints; ++j) {
    const Vector3d& axis = hand.joints[j].axis;
    if (std::abs(axis.dot(x)) < kAlong) return (axis - axis.dot(x) * x).normalized();
  }
  return x.unitOrthogonal();
}

}  // namespace

TreePose pose_tree(const BodyTree& tree, const FingerChains& chains) {
  TreePose pose;
  for (std::size_t b = 0; b < tree.bodies.size(); ++b) {
    const TreeBody& body = tree.bodies[b];
    Isometry3d X = b == 0 ? Isometry3d::Identity() : pose.X_HB[body.parent] * body.X_PB;
    std::vector<TreeAxis>& axes = pose.axes.emplace_back();
    for (std::size_t j = 0; j < body.joints.size(); ++j) {
      const TreeJoint& joint = body.joints[j];
      axes.push_back({X * joint.origin_m, X.linear() * joint.axis});
      const double offset = chains.offsets[b][j];
      if (joint.kind == TreeJointKind::kHinge) {
        const Translation3d to_joint(joint.origin_m);
        X = X * to_joint * AngleAxisd(offset, joint.axis) * to_joint.inverse();
      } else if (joint.kind == TreeJointKind::kSlide) {
        X = X * Translation3d(offset * joint.axis);
      }
    }
    pose.X_HB.push_back(X);
  }
  const Isometry3d X_HW = (pose.X_HB[chains.base] * chains.X_BH).inverse();
  for (Isometry3d& X : pose.X_HB) X = X_HW * X;
  for (std::vector<TreeAxis>& axes : pose.axes) {
    for (TreeAxis& axis : axes) {
      axis.origin_m = X_HW * axis.origin_m;
      axis.direction = (X_HW.linear() * axis.direction).normalized();
    }
  }
  return pose;
}

TreeSegments make_segments(const BodyTree& tree, const FingerChains& chains, const TreePose& pose, Hand& hand) {
  TreeSegments segments;
  segments.of_body.assign(tree.bodies.size(), 0);
  segments.body.push_back(chains.base);
  Segment palm;
  palm.name = "palm";
  palm.X_WS_0.setIdentity();
  hand.segments.push_back(palm);
  for (std::size_t k = 0; k < chains.joints.size(); ++k) {
    for (std::size_t j = 0; j < chains.joints[k].size(); ++j) {
      const ChainJoint& joint = chains.joints[k][j];
      if (j == 0 || chains.joints[k][j - 1].body != joint.body) {
        Segment segment;
        segment.name = tree.bodies[joint.body].name;
        if (segment.name == palm.name) {
          do segment.name += "_2";
          while (index_of_name(tree.bodies, segment.name) >= 0);
        }
        segment.finger = static_cast<int>(k);
        segment.X_WS_0.setIdentity();
        segment.X_WS_0.translation() = pose.axes[joint.body][joint.joint].origin_m;
        segments.of_body[joint.body] = static_cast<int>(hand.segments.size());
        segments.body.push_back(joint.body);
        hand.segments.push_back(segment);
      }
      hand.segments.back().joints = static_cast<int>(j) + 1;
    }
  }
  for (std::size_t b = 1; b < tree.bodies.size(); ++b) {
    const int with = chains.moved_with[b];
    if (with >= 0) segments.of_body[b] = segments.of_body[with];
  }
  return segments;
}

void finish_segments(Hand& hand) {
  constexpr double kNoLength_m = 1e-6;
  for (std::size_t s = 1; s < hand.segments.size(); ++s) {
    Segment& segment = hand.segments[s];
    Fingertip& tip = hand.fingertips[segment.finger];
    const bool is_last = tip.segment == static_cast<int>(s);
    const Vector3d origin = segment.X_WS_0.translation();
    const Vector3d end =
        is_last ? Vector3d(origin + tip.centre_m) : Vector3d(hand.segments[s + 1].X_WS_0.translation());
    segment.length_m = (end - origin).norm();
    const int before = s > 1 && hand.segments[s - 1].finger == segment.finger ? hand.segments[s - 1].joints : 0;
    Matrix3d R;
    Vector3d x = (end - origin).stableNormalized();
    if (segment.length_m < kNoLength_m) {
      segment.length_m = 0.0;
      const Vector3d& axis = hand.joints[tip.first_joint + before].axis;
      x = axis.unitOrthogonal();
    }
    R.col(0) = x;
    R.col(2) = across(hand, segment, x, segment.joints - before);
    R.col(1) = Vector3d(R.col(2)).cross(x);
    segment.X_WS_0.linear() = R;
    if (!is_last) continue;
    tip.centre_m = R.transpose() * tip.centre_m;
    tip.normal = R.transpose() * tip.normal;
    if (tip.shape) tip.shape->axes = (R.transpose() * tip.shape->axes).eval();
  }
}

}  // namespace thenar
