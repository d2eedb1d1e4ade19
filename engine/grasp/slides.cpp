#include "engine/grasp/slides.h"

#include <algorithm>
#include <cmath>

#include "engine/environment/environment.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// The part of a leg that began so long ago that is done.
double share_of(const PathLeg& leg, double since_s) {
  const double s = since_s / leg.over_s;
  return leg.smooth ? thenar::minimum_jerk(s) : std::clamp(s, 0.0, 1.0);
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

/// Force and spring of a slide at q [N].
double force_N(const Slide& slide, double time_s, double q) {
  const double share = slide.rise_s > 0.0 ? std::min(1.0, time_s / slide.rise_s) : 1.0;
  return share * slide.force_N + slide.stiffness_N_per_m * (slide.rest_m - q);
}

}  // namespace

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
