// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/crossing_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>

#include "engine/hand/muscles.h"

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kGood_m = 0.3e-3, kShortest_m = 3e-3;

/// Desired arms of a span, pose by pose.
struct Samples {
  std::vector<HandPose> poses;
  std::vector<int> joints;  ///< Those that the span moves.
  MatrixXd arms_m;          ///< A row a joint, a column a pose.
};

/// Joints whose arms a fit must reproduce, as rows.
using Rows = std::vector<Index>;

double arm_of(const JointVector& arms, const Samples& samples, Index row) { return arms[samples.joints[row]]; }

double length_m(const HandPose& pose, const RouteSpan& piece) {
  return (pose.segments[piece.to.segment] * piece.to.p_S - pose.segments[piece.from.segment] * piece.from.p_S).norm();
}

/// Returns arms of straight pieces minus the desired ones, pose after pose. A piece must not become so short that it
/// could reverse between two poses.
VectorXd residuals(const Hand& hand, const Samples& samples, const Rows& rows, const std::vector<RouteSpan>& pieces) {
  VectorXd off(std::ssize(samples.poses) * std::ssize(rows));
  Index next = 0;
  for (std::size_t i = 0; i < samples.poses.size(); ++i) {
    JointVector arms = hand.at_zero();
    double penalty_m = 0.0;
    for (const RouteSpan& piece : pieces) {
      arms += span_arms(hand, samples.poses[i], piece);
      if (length_m(samples.poses[i], piece) < kShortest_m) penalty_m = 1.0;
    }
    for (const Index row : rows) {
      off[next++] = penalty_m + arm_of(arms, samples, row) - samples.arms_m(row, static_cast<Index>(i));
    }
  }
  return off;
}

/// Returns unknown i; each piece has six, its ends.
double& parameter(std::vector<RouteSpan>& pieces, Index i) {
  RouteSpan& piece = pieces[static_cast<std::size_t>(i / 6)];
  return i % 6 < 3 ? piece.from.p_S[i % 6] : piece.to.p_S[i % 6 - 3];
}

/// Applies Levenberg and Marquardt's method to the ends of the pieces. A weak spring holds them near their start in
/// directions on which no arm depends. Returns the rms error [m].
double improve(const Hand& hand, const Samples& samples, const Rows& rows, std::vector<RouteSpan>& pieces) {
  constexpr double kSpring = 1e-2, kStep_m = 1e-7;  // An arm off by 1 um counts as much as a shift by 0.1 mm.
  constexpr int kSteps = 30;
  const std::vector<RouteSpan> start = pieces;
  const Index size = 6 * std::ssize(pieces);
  const auto shift = [&](std::vector<RouteSpan>& at) {
    VectorXd d(size);
    for (Index i = 0; i < size; ++i) d[i] = parameter(at, i) - parameter(const_cast<std::vector<RouteSpan>&>(start), i);
    return d;
  };
  VectorXd off = residuals(hand, samples, rows, pieces);
  const double spring = kSpring * std::sqrt(static_cast<double>(off.size()) / static_cast<double>(size));
  double cost = off.squaredNorm(), damping = 1e-3;
  for (int step = 0; step < kSteps; ++step) {
    MatrixXd J(off.size(), size);
    for (Index i = 0; i < size; ++i) {
      std::vector<RouteSpan> moved = pieces;
      parameter(moved, i) += kStep_m;
      J.col(i) = (residuals(hand, samples, rows, moved) - off) / kStep_m;
    }
    const VectorXd away = shift(pieces);
    MatrixXd A = J.transpose() * J;
    A.diagonal().array() += spring * spring;
    const VectorXd g = J.transpose() * off + spring * spring * away;
    bool better = false;
    for (int tries = 0; tries < 8 && !better; ++tries) {
      MatrixXd damped = A;
      damped.diagonal() *= 1.0 + damping;
      const VectorXd d = -damped.ldlt().solve(g);
      std::vector<RouteSpan> moved = pieces;
      for (Index i = 0; i < size; ++i) parameter(moved, i) += d[i];
      const VectorXd moved_off = residuals(hand, samples, rows, moved);
      const double moved_cost = moved_off.squaredNorm() + spring * spring * shift(moved).squaredNorm();
      better = d.allFinite() && moved_cost < cost;
      damping *= better ? 0.2 : 5.0;
      if (!better) continue;
      if (cost - moved_cost < 1e-6 * cost) step = kSteps;
      pieces = moved;
      off = moved_off;
      cost = moved_cost;
    }
    if (!better) break;
  }
  return off.size() == 0 ? 0.0 : std::sqrt(off.squaredNorm() / static_cast<double>(off.size()));
}

/// Returns straight pieces between the segments of a span and of its surface: the string's path at middle angles.
std::vector<RouteSpan> pieces_of(const RouteSpan& span, const HandPose& middle, bool straight) {
  const RouteWrap& wrapped = *span.wrap;
  const Eigen::Isometry3d X_WG = middle.segments[wrapped.segment] * wrapped.X_SG, X_GW = X_WG.inverse();
  const Vector3d from = X_GW * (middle.segments[span.from.segment] * span.from.p_S);
  const Vector3d to = X_GW * (middle.segments[span.to.segment] * span.to.p_S);
  std::optional<Vector3d> side;
  if (wrapped.side) side = X_GW * (middle.segments[wrapped.side->segment] * wrapped.side->p_S);
  auto touch = wrap(wrapped.surface, from, to, side);
  const bool is_end = wrapped.segment == span.from.segment || wrapped.segment == span.to.segment;
  if (!touch || (straight && is_end)) touch = {from, to};
  if (!touch || straight) touch = {from + 0.5 * (to - from), from + 0.5 * (to - from)};
  const SegmentPoint first{wrapped.segment, wrapped.X_SG * (*touch)[0]},
      last{wrapped.segment, wrapped.X_SG * (*touch)[1]};
  std::vector<RouteSpan> pieces;
  if (wrapped.segment == span.from.segment) {
    pieces = {{straight ? span.from : last, span.to, std::nullopt, span.share}};
  } else if (wrapped.segment == span.to.segment) {
    pieces = {{span.from, straight ? span.to : first, std::nullopt, span.share}};
  } else {
    pieces = {{span.from, first, std::nullopt, span.share}, {last, span.to, std::nullopt, span.share}};
  }
  return pieces;
}

Samples samples_of(const Hand& hand, const RouteSpan& span) {
  constexpr int kPoses = 80;
  Samples samples;
  samples.poses = random_poses(hand, kPoses, 2);
  std::vector<bool> moved(hand.joints.size(), false);
  const int around = span.wrap->segment;
  for (const auto& [one, other] : {std::pair{span.from.segment, around}, std::pair{around, span.to.segment}}) {
    for (const int joint : joints_between(hand, one, other)) moved[joint] = true;
  }
  for (std::size_t j = 0; j < moved.size(); ++j) {
    if (moved[j]) samples.joints.push_back(static_cast<int>(j));
  }
  samples.arms_m.resize(std::ssize(samples.joints), kPoses);
  for (Index i = 0; i < kPoses; ++i) {
    const JointVector arms = span_arms(hand, samples.poses[i], span);
    for (Index row = 0; row < samples.arms_m.rows(); ++row) samples.arms_m(row, i) = arm_of(arms, samples, row);
  }
  return samples;
}

/// Returns the first segment that a joint moves.
int segment_behind(const Hand& hand, int joint) {
  for (std::size_t s = 1; s < hand.segments.size(); ++s) {
    const Segment& segment = hand.segments[s];
    const int first = hand.fingertips[segment.finger].first_joint;
    if (joint >= first && joint < first + segment.joints) return static_cast<int>(s);
  }
  return 0;
}

/// Returns the arms of crossings for one joint, pose by pose.
std::vector<double> arms_alone(const Hand& hand, const Samples& samples, int joint,
                               const std::vector<MuscleCrossing>& crossings) {
  Hand alone = hand;
  alone.muscles = {{"", 0.0, crossings}};
  MatrixXd H(std::ssize(hand.joints), 1);
  std::vector<double> arms;
  for (const HandPose& pose : samples.poses) {
    moment_arms(alone, pose, H);
    arms.push_back(H(joint, 0));
  }
  return arms;
}

double rms_alone(const Hand& hand, const Samples& samples, Index row, const std::vector<MuscleCrossing>& crossings) {
  const std::vector<double> arms = arms_alone(hand, samples, samples.joints[row], crossings);
  const Eigen::Map<const Eigen::RowVectorXd> ours(arms.data(), std::ssize(arms));
  return std::sqrt((ours - samples.arms_m.row(row)).squaredNorm() / static_cast<double>(arms.size()));
}

/// Returns a crossing of one joint with a constant arm: it pulls along the bone, beside the joint.
MuscleCrossing constant_crossing(const Hand& hand, int joint, double arm_m, double share) {
  const Joint& at = hand.joints[joint];
  const int s = segment_behind(hand, joint);
  const Eigen::Isometry3d X_SW = hand.segments[s].X_WS_0.inverse();
  const Vector3d axis = X_SW.linear() * at.axis;
  const Vector3d back = -Vector3d::UnitX();
  const Vector3d across = back - back.dot(axis) * axis;
  const Vector3d D = across.norm() > 0.1 ? across.normalized() : axis.unitOrthogonal();
  return {{joint}, share, s, X_SW * at.origin_m + arm_m / share * D.cross(axis), s, D, false};
}

/// Fits crossings of one joint with arms m + a cos(q) + b sin(q): a constant arm, and a point that rotates with the
/// joint and is pulled in a fixed direction.
std::vector<MuscleCrossing> turning_crossings(const Hand& hand, const Samples& samples, Index row, double share) {
  const int joint = samples.joints[row];
  const Joint& at = hand.joints[joint];
  const int s = segment_behind(hand, joint);
  const Segment& behind = hand.segments[s];
  const int first = hand.fingertips[behind.finger].first_joint;
  int before = 0;  // The last segment that the joint does not move.
  for (int other = 1; other < s; ++other) {
    const Segment& segment = hand.segments[other];
    if (segment.finger == behind.finger && first + segment.joints <= joint) before = other;
  }
  const Eigen::Isometry3d X_SW = behind.X_WS_0.inverse(), X_PW = hand.segments[before].X_WS_0.inverse();
  const Vector3d u = at.axis.unitOrthogonal(), v = at.axis.cross(u);
  // At zero M - O = a u + b v in the hand's axes and D = v: (M - O) x D . axis = a cos(q) - b sin(q).
  MuscleCrossing turning{{joint}, share, s, X_SW * at.origin_m, before, X_PW.linear() * v, false};
  MuscleCrossing one = turning, other = turning;
  one.insertion_m = X_SW * (at.origin_m + u);
  other.insertion_m = X_SW * (at.origin_m + v);
  const std::vector<double> cosines = arms_alone(hand, samples, joint, {one}),
                            sines = arms_alone(hand, samples, joint, {other});
  MatrixXd basis(std::ssize(samples.poses), 3);
  for (Index i = 0; i < basis.rows(); ++i) {
    basis.row(i) << 1.0, cosines[static_cast<std::size_t>(i)], sines[static_cast<std::size_t>(i)];
  }
  const Vector3d fit = basis.colPivHouseholderQr().solve(samples.arms_m.row(row).transpose());
  turning.insertion_m = X_SW * (at.origin_m + fit[1] * u + fit[2] * v);
  return {constant_crossing(hand, joint, fit[0], share), turning};
}

/// Returns the simplest of several crossings for one joint alone that is good, or the best.
std::vector<MuscleCrossing> fit_joint(const Hand& hand, const RouteSpan& span, const Samples& samples, Index row,
                                      const std::vector<std::vector<RouteSpan>>& starts) {
  const int joint = samples.joints[row];
  std::vector<std::vector<MuscleCrossing>> ways{
      {constant_crossing(hand, joint, samples.arms_m.row(row).mean(), span.share)}};
  for (std::vector<RouteSpan> pieces : starts) {
    (void)improve(hand, samples, {row}, pieces);
    std::vector<MuscleCrossing>& way = ways.emplace_back();
    for (const RouteSpan& piece : pieces) {
      for (MuscleCrossing& crossing : crossings_of(hand, piece)) {
        if (std::ranges::find(crossing.joints, joint) == crossing.joints.end()) continue;
        crossing.joints = {joint};
        way.push_back(crossing);
      }
    }
  }
  ways.push_back(turning_crossings(hand, samples, row, span.share));
  std::size_t best = 0;
  double best_m = rms_alone(hand, samples, row, ways[0]);
  for (std::size_t i = 1; i < ways.size() && best_m > kGood_m; ++i) {
    const double rms_m = rms_alone(hand, samples, row, ways[i]);
    if (rms_m > 0.8 * best_m) continue;  // Earlier ones are simpler.
    best = i;
    best_m = rms_m;
  }
  return ways[best];
}

}  // namespace

std::vector<MuscleCrossing> crossings_of(const Hand& hand, const RouteSpan& span) {
  std::vector<MuscleCrossing> crossings;
  const auto add = [&](const SegmentPoint& insertion, const SegmentPoint& via) {
    MuscleCrossing crossing{{}, span.share, insertion.segment, insertion.p_S, via.segment, via.p_S, true};
    const Segment& moved = hand.segments[insertion.segment];
    const int first = hand.fingertips[moved.finger].first_joint;
    for (const int joint : joints_between(hand, insertion.segment, via.segment)) {
      if (joint >= first && joint < first + moved.joints) crossing.joints.push_back(joint);
    }
    if (!crossing.joints.empty()) crossings.push_back(crossing);
  };
  add(span.to, span.from);
  add(span.from, span.to);
  return crossings;
}

std::vector<MuscleCrossing> fit_crossings(const Hand& hand, const RouteSpan& span) {
  const Samples samples = samples_of(hand, span);
  HandPose middle;
  JointVector q = hand.at_zero();
  for (std::size_t j = 0; j < hand.joints.size(); ++j) {
    q[static_cast<Index>(j)] = 0.5 * (hand.joints[j].lower_rad + hand.joints[j].upper_rad);
  }
  forward_kinematics(hand, q, middle);
  Rows all;
  for (Index row = 0; row < samples.arms_m.rows(); ++row) all.push_back(row);

  const std::vector<std::vector<RouteSpan>> starts{pieces_of(span, middle, false), pieces_of(span, middle, true)};
  std::vector<RouteSpan> best;
  double best_m = 0.0;
  for (std::vector<RouteSpan> pieces : starts) {
    const double rms_m = improve(hand, samples, all, pieces);
    if (!best.empty() && rms_m >= best_m) continue;
    best = pieces;
    best_m = rms_m;
  }
  // Joints that common points do not serve.
  std::vector<MuscleCrossing> crossings;
  std::vector<bool> alone(hand.joints.size(), false);
  for (const Index row : all) {
    const VectorXd off = residuals(hand, samples, {row}, best);
    if (std::sqrt(off.squaredNorm() / static_cast<double>(off.size())) <= kGood_m) continue;
    alone[samples.joints[row]] = true;
    const std::vector<MuscleCrossing> own = fit_joint(hand, span, samples, row, starts);
    crossings.insert(crossings.end(), own.begin(), own.end());
  }
  for (const RouteSpan& piece : best) {
    for (MuscleCrossing& crossing : crossings_of(hand, piece)) {
      std::erase_if(crossing.joints, [&](int joint) { return alone[joint]; });
      if (!crossing.joints.empty()) crossings.insert(crossings.begin(), crossing);
    }
  }
  return crossings;
}

std::vector<HandPose> random_poses(const Hand& hand, int number, std::uint64_t seed) {
  std::mt19937_64 bits(seed);
  std::vector<HandPose> poses(static_cast<std::size_t>(number));
  for (HandPose& pose : poses) {
    JointVector q = hand.at_zero();
    for (std::size_t j = 0; j < hand.joints.size(); ++j) {
      const double share = static_cast<double>(bits() >> 11) * 0x1p-53;
      q[static_cast<Index>(j)] =
          hand.joints[j].lower_rad + share * (hand.joints[j].upper_rad - hand.joints[j].lower_rad);
    }
    forward_kinematics(hand, q, pose);
  }
  return poses;
}

}  // namespace thenar
