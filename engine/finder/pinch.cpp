// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/pinch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/blue_noise.h"
#include "engine/finder/least_squares.h"
#include "engine/grasp/pulp_touch.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

constexpr double kPinchGap_m = 0.3e-3, kSide_m = 4e-3, kNormal = 0.5, kPinchLimit_rad = 0.035, kPinchApart_m = 0.5e-3;
constexpr double kWidthStep_m = 7e-3;  // Step of widths.
constexpr double kLeast_m = -3e-3;     // Thin objects lie deep in pressed pulps.

/// The geometry of a pinch's residuals at some q.
struct Facing {
  Vector3d axis;  ///< From the opposer to the middle of the others.
  double width_m;
  double worst_cosine;  ///< Least cosine of all pulps' normals with the line.
};

class PinchFit {
 public:
  PinchFit(const Hand& hand, int opposer, double width_m)
      : hand_(hand), bones_(bones_of(hand, hand_body(hand))), opposer_(opposer), width_m_(width_m) {}

  NormalEquations operator()(const JointVector& q) {
    NormalEquations sum(q.size());
    pose(q);
    const int others = hand_.fingers() - 1;
    const Vector3d v = middle_m_ - pulps_[opposer_].centre_m;
    const double distance_m = std::max(v.norm(), 1e-6);
    const Vector3d d = v / distance_m;
    for (int k = 0; k < hand_.fingers(); ++k) {
      const double side = k == opposer_ ? 1.0 : -1.0;
      for (int i = 0; i < 3; ++i) {
        Unknowns row = Unknowns::Zero(q.size());
        add(k, pulps_[k].J_normal.row(i), row);
        add_axis(Vector3d::Unit(i), d, distance_m, -side, row);
        sum.add((pulps_[k].normal - side * d)[i] / kNormal, row / kNormal);
      }
      if (k == opposer_) continue;
      // The others are in one plane, and apart from one another.
      Unknowns row = Unknowns::Zero(q.size());
      add(k, d.transpose() * pulps_[k].J_centre, row);
      sum.add(d.dot(pulps_[k].centre_m - middle_m_) / kSide_m, row / kSide_m);
      for (int other = 0; other < k; ++other) {
        if (other != opposer_) keep_apart(k, other, sum);
      }
    }
    Unknowns row = Unknowns::Zero(q.size());
    for (int k = 0; k < hand_.fingers(); ++k) {
      const double share = k == opposer_ ? -1.0 : 1.0 / others;
      add(k, share * d.transpose() * pulps_[k].J_centre, row);
    }
    sum.add((distance_m - width_m_ - radii_m()) / kPinchGap_m, row / kPinchGap_m);
    keep_limits(q, sum);
    return sum;
  }

  [[nodiscard]] Facing facing(const JointVector& q) {
    pose(q);
    const Vector3d v = middle_m_ - pulps_[opposer_].centre_m;
    Facing facing{v.normalized(), v.norm() - radii_m(), 1.0};
    for (int k = 0; k < hand_.fingers(); ++k) {
      const double side = k == opposer_ ? 1.0 : -1.0;
      facing.worst_cosine = std::min(facing.worst_cosine, side * pulps_[k].normal.dot(facing.axis));
    }
    return facing;
  }

  /// Returns the pinch of the last posture, at the middles of the pulps.
  [[nodiscard]] double least_dexterity() const {
    double least = 1.0;
    for (int k = 0; k < hand_.fingers(); ++k) least = std::min(least, dexterity(hand_, pose_, k, pulps_[k].centre_m));
    return least;
  }

  /// Returns the overlap of its bones, likewise.
  [[nodiscard]] double overlap_m() const { return overlap_of(bones_, pose_).depth_m; }

  [[nodiscard]] Vector3d gap_middle_m() const {
    const Vector3d v = middle_m_ - pulps_[opposer_].centre_m;
    const Vector3d from_m = pulps_[opposer_].centre_m + thick_m(opposer_) * v.normalized();
    return from_m + 0.5 * (v.norm() - radii_m()) * v.normalized();
  }

 private:
  void pose(const JointVector& q) {
    forward_kinematics(hand_, q, pose_);
    pulps_ = PerFinger<PulpPose>(hand_.fingers());
    middle_m_.setZero();
    for (int k = 0; k < hand_.fingers(); ++k) {
      pulps_[k] = pulp_pose(hand_, pose_, k);
      if (k != opposer_) middle_m_ += pulps_[k].centre_m / (hand_.fingers() - 1);
    }
  }

  /// Returns the extent of a pulp in its direction.
  [[nodiscard]] double thick_m(int k) const { return extent_m(hand_.fingertips[k], hand_.fingertips[k].normal); }

  /// Returns the extent of the opposer plus the mean of the others'.
  [[nodiscard]] double radii_m() const {
    double sum = thick_m(opposer_);
    for (int k = 0; k < hand_.fingers(); ++k) {
      if (k != opposer_) sum += thick_m(k) / (hand_.fingers() - 1);
    }
    return sum;
  }

  template <typename Row>
  void add(int k, const Row& of_finger, Unknowns& row) const {
    const Fingertip& tip = hand_.fingertips[k];
    for (int j = 0; j < tip.joints; ++j) row[tip.first_joint + j] += of_finger[j];
  }

  /// Returns the derivative of d along `direction`.
  void add_axis(const Vector3d& direction, const Vector3d& d, double distance_m, double sign, Unknowns& row) const {
    const Vector3d across = sign * (direction - d * d.dot(direction)) / distance_m;
    for (int k = 0; k < hand_.fingers(); ++k) {
      const double share = k == opposer_ ? -1.0 : 1.0 / (hand_.fingers() - 1);
      add(k, share * across.transpose() * pulps_[k].J_centre, row);
    }
  }

  void keep_apart(int k, int other, NormalEquations& sum) const {
    const Vector3d v = pulps_[k].centre_m - pulps_[other].centre_m;
    const Vector3d d = v.normalized();
    Unknowns row = Unknowns::Zero(sum.Jr.size());
    add(k, -d.transpose() * pulps_[k].J_centre, row);
    add(other, d.transpose() * pulps_[other].J_centre, row);
    sum.add_hinge(touching_m(hand_, pose_, k, other, d) - v.norm(), kPinchApart_m, row);
  }

  void keep_limits(const JointVector& q, NormalEquations& sum) const {
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Joint& joint = hand_.joints[i];
      const double inner_rad = std::min(2.0 * kPinchLimit_rad, 0.2 * (joint.upper_rad - joint.lower_rad));
      Unknowns row = Unknowns::Zero(q.size());
      row[i] = 1.0;
      sum.add_hinge(q[i] - joint.upper_rad + inner_rad, 2.0 * kPinchLimit_rad, row);
      sum.add_hinge(joint.lower_rad + inner_rad - q[i], 2.0 * kPinchLimit_rad, -row);
      const double half_rad = std::max(1e-3, 0.5 * (joint.upper_rad - joint.lower_rad));
      sum.add(0.1 * (q[i] - 0.5 * (joint.lower_rad + joint.upper_rad)) / half_rad, 0.1 * row / half_rad);
    }
  }

  const Hand& hand_;
  Bones bones_;
  int opposer_;
  double width_m_;
  HandPose pose_;
  PerFinger<PulpPose> pulps_;
  Vector3d middle_m_;
};

JointVector within_limits(const Hand& hand, JointVector q) {
  for (Eigen::Index i = 0; i < q.size(); ++i)
    q[i] = std::clamp(q[i], hand.joints[i].lower_rad, hand.joints[i].upper_rad);
  return q;
}

/// Returns the postures of one width, the best first, each unlike those before.
std::vector<Pinch> pinches_of(const Hand& hand, int opposer, double width_m, int starts, Uniform& uniform,
                              double& best_cosine) {
  constexpr double kWidthError_m = 1e-3, kAlike_rad = 0.25, kDexterous = 0.15, kOverlap_m = 1e-3;
  PinchFit fit(hand, opposer, width_m);
  std::vector<Pinch> found;
  for (int start = 0; start < starts; ++start) {
    JointVector q = hand.at_zero();
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Joint& joint = hand.joints[i];
      q[i] = joint.lower_rad + (joint.upper_rad - joint.lower_rad) * (start == 0 ? 0.5 : uniform());
    }
    const auto moved = [&](const JointVector& from, const Unknowns& step) { return within_limits(hand, from + step); };
    q = least_squares(
        q, 40, [&](const JointVector& x) { return fit(x); }, moved);
    const Facing facing = fit.facing(q);
    if (std::abs(facing.width_m - width_m) > kWidthError_m) continue;
    best_cosine = std::max(best_cosine, facing.worst_cosine);
    if (facing.worst_cosine < std::cos(kFacing_rad)) continue;
    const Vector3d middle_m = fit.gap_middle_m();
    const double cost =
        fit(q).cost + 10.0 * std::max(0.0, 1.0 - fit.least_dexterity() / kDexterous) + fit.overlap_m() / kOverlap_m;
    found.push_back({width_m, q, facing.axis, middle_m, cost});
  }
  std::sort(found.begin(), found.end(), [](const Pinch& a, const Pinch& b) { return a.cost < b.cost; });
  std::vector<Pinch> unlike;
  for (const Pinch& pinch : found) {
    const bool is_new = std::all_of(unlike.begin(), unlike.end(), [&](const Pinch& other) {
      return (pinch.q - other.q).cwiseAbs().maxCoeff() > kAlike_rad;
    });
    if (is_new && unlike.size() < 3) unlike.push_back(pinch);
  }
  return unlike;
}

PinchRange range_of(const Hand& hand, int opposer, std::uint32_t seed, int starts) {
  constexpr double kWidest_m = 0.3;
  Uniform uniform(seed);
  PinchRange range{.opposer = opposer};
  double best_cosine = -1.0;
  int misses = 0;
  for (double width_m = kLeast_m; width_m < kWidest_m && misses < 2; width_m += kWidthStep_m) {
    const std::vector<Pinch> pinches = pinches_of(hand, opposer, width_m, starts, uniform, best_cosine);
    misses = pinches.empty() && !range.postures.empty() ? misses + 1 : 0;
    if (pinches.empty() && range.postures.empty() && width_m > 0.1) break;
    range.postures.insert(range.postures.end(), pinches.begin(), pinches.end());
  }
  range.best_facing_rad = std::acos(std::clamp(best_cosine, -1.0, 1.0));
  if (range.postures.empty()) {
    range.opposer = -1;
    return range;
  }
  range.least_m = range.postures.front().width_m;
  range.most_m = range.postures.back().width_m;
  return range;
}

}  // namespace

PinchRange find_pinches(const Hand& hand, std::uint32_t seed, int effort) {
  // A few starts reveal the opposing finger; the thumb is the only one in nearly all hands.
  PinchRange best;
  best.best_facing_rad = std::numbers::pi;
  double best_value = 0.0;
  for (int k = 0; k < hand.fingers(); ++k) {
    if (hand.fingers() == 2 && k == 1) break;  // the same the other way round
    PinchRange range = range_of(hand, k, seed, 4);
    double cost = 0.0;
    for (const Pinch& pinch : range.postures) cost += pinch.cost / static_cast<double>(range.postures.size());
    const double value = range.opposer < 0 ? 0.0 : (range.most_m - range.least_m + kWidthStep_m) / (1.0 + cost);
    if (range.opposer < 0 && best.opposer < 0)
      best.best_facing_rad = std::min(best.best_facing_rad, range.best_facing_rad);
    if (value <= best_value) continue;
    best_value = value;
    best = std::move(range);
  }
  if (best.opposer < 0) return best;
  return range_of(hand, best.opposer, seed, 10 * effort);
}

Vector3d approach_of(const Hand& hand, const Pinch& pinch) {
  Vector3d palm_m = Vector3d::Zero();
  for (const Fingertip& tip : hand.fingertips) palm_m += hand.joints[tip.first_joint].origin_m / hand.fingers();
  const Vector3d way_m = pinch.middle_m - palm_m;
  return way_m.norm() > 1e-6 ? Vector3d(way_m.normalized()) : Vector3d::UnitX();
}

}  // namespace thenar
