// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/slides.h"

#include <algorithm>
#include <cmath>

#include "engine/environment/minimum_jerk.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// The part of a leg that began so long ago that is done.
double share_of(const PathLeg& leg, double since_s) {
  const double s = since_s / leg.over_s;
  return leg.smooth ? minimum_jerk(s) : std::clamp(s, 0.0, 1.0);
}

/// The length of the path between two times.
double length_m(const Slide& slide, double from_s, double to_s) {
  double length_m = 0.0, begin_s = 0.0;
  for (const PathLeg& leg : slide.path) {
    length_m += leg.by_m.norm() * (share_of(leg, to_s - begin_s) - share_of(leg, from_s - begin_s));
    begin_s += leg.over_s;
  }
  return length_m;
}

/// Axes of the segment that carries a fingertip: x from it along the rod that it is drawn with.
Matrix3d rod_axes(const Vector3d& along) {
  Matrix3d axes;
  axes.col(0) = -along;
  axes.col(1) = along.unitOrthogonal();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

/// Force and spring of a slide at q [N].
double force_N(const Slide& slide, double time_s, double q) {
  const double share = slide.rise_s > 0.0 ? std::min(1.0, time_s / slide.rise_s) : 1.0;
  return share * slide.force_N + slide.stiffness_N_per_m * (slide.rest_m - q);
}

}  // namespace

Hand hand_of_slides() {
  Hand hand;
  hand.slides = true;
  Segment frame;
  frame.name = "frame";
  frame.X_WS_0.setIdentity();
  hand.segments.push_back(frame);
  return hand;
}

void add_slide(const std::string& name, const Vector3d& at_m, const Vector3d& along, double radius_m, bool has_path,
               Hand& hand) {
  constexpr double kRodsPerRadius = 5.0;  // How long the rod is that a fingertip is drawn with.
  Fingertip tip;
  tip.finger = name;
  tip.first_joint = static_cast<int>(hand.joints.size());
  tip.joints = has_path ? 3 : 1;
  tip.segment = static_cast<int>(hand.segments.size());
  tip.centre_m.setZero();
  tip.radius_m = radius_m;
  tip.normal = -Vector3d::UnitX();
  tip.joint_viscosity = kSlideDamping_N_s_per_m;
  if (has_path) {
    // Beyond where paths end: no stop is in their way.
    const char* const axes[] = {"x", "y", "z"};
    for (int i = 0; i < 3; ++i) {
      const double stop_m = 2.0 * kSlideReach_m;
      hand.joints.push_back({name + "_travel_" + axes[i], at_m, Vector3d::Unit(i), -stop_m, stop_m});
    }
  } else {
    hand.joints.push_back({name + "_travel", at_m, along, -kSlideReach_m, kSlideReach_m});
  }
  Segment segment;
  segment.name = name;
  segment.finger = hand.fingers();
  segment.joints = tip.joints;
  segment.X_WS_0.setIdentity();
  segment.X_WS_0.linear() = rod_axes(along);
  segment.X_WS_0.translation() = at_m;
  segment.length_m = kRodsPerRadius * radius_m;
  hand.segments.push_back(segment);
  hand.fingertips.push_back(tip);
}

// Calls of their own: inlined, they would have the products of all other scenes' ticks contracted otherwise.

[[gnu::noinline]] Vector3d path_m(const Slide& slide, double time_s) {
  Vector3d place_m = Vector3d::Zero();
  double begin_s = 0.0;
  for (const PathLeg& leg : slide.path) {
    place_m += share_of(leg, time_s - begin_s) * leg.by_m;
    begin_s += leg.over_s;
  }
  return place_m;
}

[[gnu::noinline]] void drive_slides(const Scene& scene, double time_s, const JointVector& q, JointVector& drive_N) {
  for (int k = 0; k < std::ssize(scene.slides); ++k) {
    const Fingertip& tip = scene.hand.fingertips[k];
    if (scene.has_path(k)) {
      drive_N.segment(tip.first_joint, tip.joints).setZero();
    } else {
      drive_N[tip.first_joint] += force_N(scene.slides[k], time_s, q[tip.first_joint]);
    }
  }
}

[[gnu::noinline]] double slide_travel_m(const Scene& scene, const Snapshot& snapshot, const JointVector& drive_N, int k,
                                        double time_s) {
  const Slide& slide = scene.slides[k];
  const double now_s = static_cast<double>(snapshot.tick) * scene.step_s;
  if (scene.has_path(k)) return length_m(slide, now_s, now_s + time_s);
  const int j = scene.hand.fingertips[k].first_joint;
  const double net_N = force_N(slide, now_s + time_s, snapshot.q[j]) + drive_N[j] -
                       scene.hand.joints[j].axis.dot(snapshot.load[k].force_N);
  return std::abs(net_N) * time_s / (scene.viscosity(k) + time_s * slide.stiffness_N_per_m);
}

[[gnu::noinline]] void follow_paths(const Scene& scene, double end_s, const JointVector& q, JointVector& dq) {
  for (int k = 0; k < std::ssize(scene.slides); ++k) {
    if (!scene.has_path(k)) continue;
    const Index j = scene.hand.fingertips[k].first_joint;
    dq.segment<3>(j) = path_m(scene.slides[k], end_s) - q.segment<3>(j);
  }
}

[[gnu::noinline]] void book_slides(const Scene& scene, const Frame& frame, const ContactKinematics& kinematics,
                                   const Eigen::VectorXd& f, const JointVector& dq, Ledger& ledger) {
  for (int k = 0; k < std::ssize(scene.slides); ++k) {
    const Index j = scene.hand.fingertips[k].first_joint;
    if (!scene.has_path(k)) {
      ledger.drive_J -= scene.slides[k].stiffness_N_per_m * dq[j] * dq[j];
      continue;
    }
    const Index first = 3 * frame.begin[k], rows = 3 * frame.begin[k + 1] - first;
    for (int c = 0; c < 3; ++c) {
      const double contact_N = kinematics.J_finger.col(c).segment(first, rows).dot(f.segment(first, rows));
      ledger.drive_J -= contact_N * dq[j + c];
    }
    ledger.viscous_J -= scene.viscosity(k) * dq.segment<3>(j).squaredNorm() / scene.step_s;
  }
}

}  // namespace thenar
