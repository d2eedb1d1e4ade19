// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/finder/pinch.h"
#include "engine/grasp/pulp_touch.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Units of the residuals.
constexpr double kGap_m = 0.05e-3, kCosine = 0.05, kBody_m = 0.5e-3, kApart_m = 0.3e-3, kLimit_rad = 0.15;
constexpr double kBalance = 0.12, kAnchor_m = 12e-3, kPosture_rad = 1.0, kCentre_m = 40e-3;
constexpr double kAxis = 0.05, kAt_m = 2e-3, kApproach = 0.1;
// Bounds of a grasp.
constexpr double kMostGap_m = 0.1e-3, kMostBody_m = 1e-3, kMostApart_m = 0.6e-3;
constexpr double kMostAxis_rad = 0.17, kMostAt_m = 6e-3, kMostApproach_rad = 0.52;
constexpr double kEase_rad = 0.3;     // Distance from which limits count: a carrying hand bends.
constexpr double kSpare_rad = 0.052;  // Least distance of joints from their limits, as a grip closes further.

Matrix3d cross(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

double beyond(double value, double bound) { return std::max(0.0, value - bound); }

double spare_rad(const Joint& joint) { return std::min(kSpare_rad, 0.1 * (joint.upper_rad - joint.lower_rad)); }

}  // namespace

double FitFaults::badness() const {
  return gap_m / kMostGap_m + facing_rad / 0.1 + body_m / kMostBody_m + apart_m / kMostApart_m +
         bones_m / kMostApart_m + limit_rad / 0.03 + axis_rad / 0.1 + at_m / 3e-3 + approach_rad / 0.2;
}

Stance moved(const Hand& hand, const Stance& stance, const Unknowns& step, bool limits) {
  Stance next = stance;
  const Index joints = stance.q.size();
  const double scale = std::min(1.0, 0.5 / std::max(1e-12, step.cwiseAbs().maxCoeff()));
  next.q += scale * step.head(joints);
  for (Index i = 0; i < joints && limits; ++i) {
    next.q[i] = std::clamp(next.q[i], hand.joints[i].lower_rad, hand.joints[i].upper_rad);
  }
  next.X_WO.translation() += scale * step.segment<3>(joints);
  const Vector3d turn = scale * step.tail<3>();
  if (const double angle = turn.norm(); angle > 0.0) {
    next.X_WO.linear() = (Eigen::AngleAxisd(angle, turn / angle) * stance.X_WO.linear()).eval();
  }
  return next;
}

StanceFit::StanceFit(const Hand& hand, const std::vector<BodyPoint>& body, const ImplicitSurface& object)
    : hand_(hand),
      body_(body),
      object_(object),
      bones_(bones_of(hand, body)),
      bones_W_(bones_.points.size()),
      unknowns_(static_cast<Index>(hand.joints.size()) + 6),
      fingers_(hand.fingers()),
      X_WO_(Isometry3d::Identity()) {}

SurfaceDistance StanceFit::distance(const Vector3d& x_O) const {
  return *object_.distance(x_O, std::numeric_limits<double>::infinity());
}

void StanceFit::look(const Stance& stance, const FitTarget& target, bool with_slopes) {
  constexpr double kSlope_m = 0.4e-3;
  forward_kinematics(hand_, stance.q, pose_);
  X_WO_ = stance.X_WO;
  const Matrix3d& R = X_WO_.linear();
  const Index joints = stance.q.size();
  for (int k = 0; k < hand_.fingers(); ++k) {
    Finger& finger = fingers_[k];
    finger.pulp = pulp_pose(hand_, pose_, k);
    finger.c_O = X_WO_.inverse() * finger.pulp.centre_m;
    const Fingertip& tip = hand_.fingertips[k];
    const Isometry3d& X_WF = pose_.distal(hand_, k);
    const PulpBall ball = touching_ball(tip, object_, X_WO_.inverse() * X_WF);
    const Vector3d ball_m = X_WF * ball.centre_m, p_O = X_WO_.inverse() * ball_m;
    const SurfaceDistance at = distance(p_O);
    finger.gap_m = at.distance_m - ball.radius_m + target.depth_m[k];
    finger.point_O = at.point_m;
    finger.normal_O = at.normal;
    finger.n_W = R * at.normal;
    if (!with_slopes) continue;
    Matrix3d slope;
    for (int i = 0; i < 3; ++i) {
      slope.col(i) = (distance(p_O + kSlope_m * Vector3d::Unit(i)).normal - at.normal) / kSlope_m;
    }
    finger.C = finger.M = finger.G = finger.N = Rows::Zero(3, unknowns_);
    finger.C.middleCols(tip.first_joint, tip.joints) = finger.pulp.J_centre.leftCols(tip.joints);
    finger.M.middleCols(tip.first_joint, tip.joints) = finger.pulp.J_normal.leftCols(tip.joints);
    finger.G = finger.C;
    if (tip.shape) {
      const FingerJacobian J = finger_jacobian(hand_, pose_, k, ball_m);
      finger.G.middleCols(tip.first_joint, tip.joints) = J.leftCols(tip.joints);
    }
    finger.G.middleCols<3>(joints) = -Matrix3d::Identity();
    finger.G.middleCols<3>(joints + 3) = cross(ball_m - X_WO_.translation());
    finger.N = R * slope * R.transpose() * finger.G;
    finger.N.middleCols<3>(joints + 3) -= cross(finger.n_W);
  }
}

void StanceFit::add_touches(const FitTarget& target, NormalEquations& sum) const {
  for (int k = 0; k < hand_.fingers(); ++k) {
    const Finger& finger = fingers_[k];
    // A far gap counts less than in proportion.
    const double soft = 1.0 + std::abs(finger.gap_m) / 1e-3;
    sum.add(finger.gap_m / (kGap_m * soft), finger.G.transpose() * finger.n_W / (kGap_m * soft));
    const double cosine = -finger.pulp.normal.dot(finger.n_W);
    const Unknowns slope = finger.M.transpose() * finger.n_W + finger.N.transpose() * finger.pulp.normal;
    sum.add_hinge(std::cos(kFacing_rad - 0.05) - cosine, kCosine, slope);
    // Parallel normals are slightly better.
    sum.add(1.2 * (1.0 - cosine), 1.2 * slope);
  }
  // Where the opposition was found.
  const auto anchor = [&](const Vector3d& place_O, const Vector3d& from_O, const Rows& moves) {
    const Vector3d miss = X_WO_.linear() * (from_O - place_O) / kAnchor_m;
    for (int i = 0; i < 3; ++i) sum.add(miss[i], moves.row(i).transpose() / kAnchor_m);
  };
  const int others = hand_.fingers() - 1;
  Vector3d middle_O = Vector3d::Zero();
  Rows middle = Rows::Zero(3, unknowns_);
  for (int k = 0; k < hand_.fingers(); ++k) {
    if (k == target.opposer) continue;
    middle_O += fingers_[k].point_O / others;
    middle += fingers_[k].G / others;
  }
  if (target.opposer_O) anchor(*target.opposer_O, fingers_[target.opposer].point_O, fingers_[target.opposer].G);
  if (target.others_O) anchor(*target.others_O, middle_O, middle);
}

/// Adds the balance of normal forces alone, the opposer's as large as the others' together, in force and moment.
void StanceFit::add_balance(const FitTarget& target, NormalEquations& sum) const {
  const int fingers = hand_.fingers();
  Vector3d middle_m = Vector3d::Zero();
  for (const Finger& finger : fingers_) middle_m += finger.pulp.centre_m / fingers;
  double lever_m = 0.0;
  for (const Finger& finger : fingers_) lever_m += (finger.pulp.centre_m - middle_m).norm() / fingers;
  lever_m = std::max(lever_m, 1e-3);
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();
  Rows forces = Rows::Zero(3, unknowns_), moments = forces;
  for (int k = 0; k < fingers; ++k) {
    const Finger& finger = fingers_[k];
    const double share = (k == target.opposer ? fingers - 1.0 : 1.0) / (2.0 * (fingers - 1.0));
    const Vector3d arm_m = finger.pulp.centre_m - middle_m;
    force += share * finger.n_W;
    forces += share * finger.N;
    moment += share * arm_m.cross(finger.n_W) / lever_m;
    moments += share / lever_m * (cross(arm_m) * finger.N - cross(finger.n_W) * finger.C);
  }
  for (int i = 0; i < 3; ++i) {
    sum.add(force[i] / kBalance, forces.row(i).transpose() / kBalance);
    sum.add(moment[i] / kBalance, moments.row(i).transpose() / kBalance);
  }
  // The weight is best borne if it acts between the fingers.
  const Vector3d off_m = X_WO_ * target.centre_of_mass_m - middle_m;
  Rows off = Rows::Zero(3, unknowns_);
  off.middleCols<3>(unknowns_ - 6) = Matrix3d::Identity();
  off.middleCols<3>(unknowns_ - 3) = -cross(X_WO_.linear() * target.centre_of_mass_m);
  for (const Finger& finger : fingers_) off -= finger.C / fingers;
  for (int i = 0; i < 3; ++i) sum.add(off_m[i] / kCentre_m, off.row(i).transpose() / kCentre_m);
}

void StanceFit::add_way(const BodyPoint& point, const Vector3d& p_W, const Vector3d& d, Unknowns& row) const {
  if (point.segment < 0) return;
  const int first = hand_.fingertips[point.finger].first_joint;
  const FingerJacobian J = segment_jacobian(hand_, pose_, hand_.segments[point.segment], p_W);
  row.segment(first, point.joints) += J.leftCols(point.joints).transpose() * d;
}

void StanceFit::add_body(const Stance& stance, NormalEquations& sum) const {
  const Index joints = stance.q.size();
  for (const BodyPoint& point : body_) {
    const Vector3d p_W = point.in(pose_);
    const Vector3d p_O = X_WO_.inverse() * p_W;
    if (object_.bounds().squaredExteriorDistance(p_O) > point.clearance_m * point.clearance_m) continue;
    const SurfaceDistance at = distance(p_O);
    if (at.distance_m >= point.clearance_m) continue;
    const Vector3d n_W = X_WO_.linear() * at.normal;
    Unknowns row = Unknowns::Zero(unknowns_);
    row.segment<3>(joints) = n_W;
    row.tail<3>() = (p_W - X_WO_.translation()).cross(n_W);
    add_way(point, p_W, -n_W, row);
    sum.add_hinge(point.clearance_m - at.distance_m, kBody_m, row);
  }
}

void StanceFit::add_apart(NormalEquations& sum) const {
  for (int k = 0; k < hand_.fingers(); ++k) {
    for (int other = 0; other < k; ++other) {
      const Vector3d v = fingers_[k].pulp.centre_m - fingers_[other].pulp.centre_m;
      const Vector3d d = v.normalized();
      const double least_m = touching_m(hand_, pose_, k, other, d);
      if (v.squaredNorm() >= least_m * least_m || v.squaredNorm() == 0.0) continue;
      sum.add_hinge(least_m - v.norm(), kApart_m, (fingers_[other].C - fingers_[k].C).transpose() * d);
    }
  }
}

void StanceFit::add_bones(NormalEquations& sum) {
  for (std::size_t i = 0; i < bones_W_.size(); ++i) bones_W_[i] = bones_.points[i].in(pose_);
  for (const BonePair& pair : bones_.pairs) {
    const Vector3d v = bones_W_[pair.a] - bones_W_[pair.b];
    if (v.squaredNorm() >= pair.least_m * pair.least_m || v.squaredNorm() == 0.0) continue;
    const Vector3d d = v.normalized();
    Unknowns row = Unknowns::Zero(unknowns_);
    add_way(bones_.points[pair.a], bones_W_[pair.a], -d, row);
    add_way(bones_.points[pair.b], bones_W_[pair.b], d, row);
    sum.add_hinge(pair.least_m - v.norm(), kBody_m, row);
  }
}

void StanceFit::add_limits(const Stance& stance, const FitTarget& target, NormalEquations& sum) const {
  for (Index i = 0; i < stance.q.size(); ++i) {
    Unknowns row = Unknowns::Zero(unknowns_);
    row[i] = 1.0;
    sum.add((stance.q[i] - target.q_near[i]) / kPosture_rad, row / kPosture_rad);
    if (!target.limits) continue;
    const Joint& joint = hand_.joints[i];
    const double inner_rad = std::min(kEase_rad, 0.3 * (joint.upper_rad - joint.lower_rad));
    sum.add_hinge(stance.q[i] - joint.upper_rad + inner_rad, kLimit_rad, row);
    sum.add_hinge(joint.lower_rad + inner_rad - stance.q[i], kLimit_rad, -row);
  }
}

void StanceFit::add_wishes(const Stance& stance, const FitTarget& target, NormalEquations& sum) const {
  const GraspWish& wish = target.wish;
  if (!wish.axis_O && !wish.at_O && !wish.approach_O) return;
  const int others = hand_.fingers() - 1;
  const Finger& opposer = fingers_[target.opposer];
  Vector3d middle_m = Vector3d::Zero();
  Rows middle = Rows::Zero(3, unknowns_);
  for (int k = 0; k < hand_.fingers(); ++k) {
    if (k == target.opposer) continue;
    middle_m += fingers_[k].pulp.centre_m / others;
    middle += fingers_[k].C / others;
  }
  const auto turned = [&](const Vector3d& v_O) {  // v_O in the world, and how it turns
    Rows rows = Rows::Zero(3, unknowns_);
    rows.middleCols<3>(unknowns_ - 3) = -cross(stance.X_WO.linear() * v_O);
    return rows;
  };
  const auto add = [&](const Vector3d& miss, const Rows& rows, double scale) {
    for (int i = 0; i < 3; ++i) sum.add(miss[i] / scale, rows.row(i).transpose() / scale);
  };
  if (wish.axis_O) {
    const Vector3d v = middle_m - opposer.pulp.centre_m, u = v.normalized();
    const Vector3d wanted_O = u.dot(stance.X_WO.linear() * *wish.axis_O) < 0.0 ? -*wish.axis_O : *wish.axis_O;
    const Matrix3d across = (Matrix3d::Identity() - u * u.transpose()) / v.norm();
    add(u - stance.X_WO.linear() * wanted_O, across * (middle - opposer.C) - turned(wanted_O), kAxis);
  }
  if (wish.at_O) {
    Rows at = turned(*wish.at_O);
    at.middleCols<3>(unknowns_ - 6) += Matrix3d::Identity();
    const Vector3d centre_m = 0.5 * (middle_m + opposer.pulp.centre_m);
    add(centre_m - stance.X_WO * *wish.at_O, 0.5 * (middle + opposer.C) - at, kAt_m);
  }
  if (wish.approach_O) {
    add(target.approach_W - stance.X_WO.linear() * *wish.approach_O, -turned(*wish.approach_O), kApproach);
  }
}

NormalEquations StanceFit::equations(const Stance& stance, const FitTarget& target) {
  look(stance, target, true);
  NormalEquations sum(unknowns_);
  add_touches(target, sum);
  add_balance(target, sum);
  add_body(stance, sum);
  add_apart(sum);
  add_bones(sum);
  add_limits(stance, target, sum);
  add_wishes(stance, target, sum);
  return sum;
}

Stance StanceFit::fit(const Stance& start, const FitTarget& target, int most_steps) {
  return least_squares(
      start, most_steps, [&](const Stance& stance) { return equations(stance, target); },
      [&](const Stance& stance, const Unknowns& step) { return moved(hand_, stance, step, target.limits); });
}

double StanceFit::rough_cost(const Stance& stance, const HandPose& pose, const FitTarget& target, double enough) const {
  constexpr double kRoughGap_m = 6e-3, kRoughBody_m = 3e-3;
  const Isometry3d X_OW = stance.X_WO.inverse();
  double cost = 0.0;
  if (target.wish.approach_O) {
    cost += (target.approach_W - stance.X_WO.linear() * *target.wish.approach_O).squaredNorm() / 0.09;
  }
  for (int k = 0; k < hand_.fingers(); ++k) {
    const Fingertip& tip = hand_.fingertips[k];
    const Isometry3d& X_WF = pose.distal(hand_, k);
    const SurfaceDistance at = distance(X_OW * (X_WF * tip.centre_m));
    const double reach_m = extent_m(tip, X_WF.linear().transpose() * (X_OW.linear().transpose() * at.normal));
    const double gap_m = at.distance_m - reach_m + target.depth_m[k];
    cost += gap_m * gap_m / (kRoughGap_m * kRoughGap_m);
    const double cosine = -(X_OW.linear() * (X_WF.linear() * tip.normal)).dot(at.normal);
    cost += std::pow(beyond(std::cos(kFacing_rad), cosine) / 0.2, 2);
    if (cost > enough) return cost;
  }
  for (const BodyPoint& point : body_) {
    const Vector3d p_W = point.in(pose);
    const Vector3d p_O = X_OW * p_W;
    if (object_.bounds().squaredExteriorDistance(p_O) > point.clearance_m * point.clearance_m) continue;
    cost += std::pow(beyond(point.clearance_m, distance(p_O).distance_m) / kRoughBody_m, 2);
    if (cost > enough) return cost;
  }
  return cost;
}

PerFinger<FoundTouch> StanceFit::touches(const Stance& stance, const FitTarget& target) {
  look(stance, target, false);
  PerFinger<FoundTouch> touches(hand_.fingers());
  for (int k = 0; k < hand_.fingers(); ++k) {
    const Finger& finger = fingers_[k];
    touches[k] = {finger.gap_m, finger.point_O, finger.normal_O, -finger.pulp.normal.dot(finger.n_W)};
  }
  return touches;
}

FitFaults StanceFit::faults(const Stance& stance, const FitTarget& target) {
  look(stance, target, false);
  FitFaults faults;
  const int others = hand_.fingers() - 1;
  Vector3d middle_O = Vector3d::Zero();
  for (int k = 0; k < hand_.fingers(); ++k) {
    const Finger& finger = fingers_[k];
    faults.gap_m = std::max(faults.gap_m, beyond(std::abs(finger.gap_m), kMostGap_m));
    const double angle_rad = std::acos(std::clamp(-finger.pulp.normal.dot(finger.n_W), -1.0, 1.0));
    if (const double over_rad = beyond(angle_rad, kFacing_rad); over_rad > faults.facing_rad) {
      faults.facing_rad = over_rad;
      faults.facing_finger = k;
    }
    if (k != target.opposer) middle_O += finger.c_O / std::max(1, others);
    for (int other = 0; other < k; ++other) {
      const double apart_m = (finger.c_O - fingers_[other].c_O).norm();
      const Vector3d d = (finger.pulp.centre_m - fingers_[other].pulp.centre_m).normalized();
      const double least_m = touching_m(hand_, pose_, k, other, d);
      faults.apart_m = std::max(faults.apart_m, beyond(least_m - apart_m, kMostApart_m));
    }
  }
  const BoneOverlap overlap = overlap_of(bones_, pose_);
  faults.bones_m = beyond(overlap.depth_m, kMostApart_m);
  faults.bones_finger = overlap.finger;
  faults.bones_other = overlap.other;
  for (const BodyPoint& point : body_) {
    const Vector3d p_W = point.in(pose_);
    const Vector3d p_O = X_WO_.inverse() * p_W;
    if (object_.bounds().squaredExteriorDistance(p_O) > point.clearance_m * point.clearance_m) continue;
    const double in_m = beyond(point.clearance_m - distance(p_O).distance_m, kMostBody_m);
    if (in_m <= faults.body_m) continue;
    faults.body_m = in_m;
    faults.body_segment = point.segment;
  }
  for (Index i = 0; i < stance.q.size(); ++i) {
    const Joint& joint = hand_.joints[i];
    const double spare = 0.5 * spare_rad(joint);
    const double over_rad =
        std::max(beyond(stance.q[i], joint.upper_rad - spare), beyond(joint.lower_rad + spare, stance.q[i]));
    faults.limit_rad = std::max(faults.limit_rad, over_rad);
  }
  const GraspWish& wish = target.wish;
  const Vector3d u_O = (middle_O - fingers_[target.opposer].c_O).normalized();
  const Vector3d centre_O = 0.5 * (middle_O + fingers_[target.opposer].c_O);
  const auto angle = [](double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)); };
  if (wish.axis_O) faults.axis_rad = beyond(angle(std::abs(u_O.dot(*wish.axis_O))), kMostAxis_rad);
  if (wish.at_O) faults.at_m = beyond((centre_O - *wish.at_O).norm(), kMostAt_m);
  if (wish.approach_O) {
    const double cosine = target.approach_W.dot(X_WO_.linear() * *wish.approach_O);
    faults.approach_rad = beyond(angle(cosine), kMostApproach_rad);
  }
  return faults;
}

}  // namespace thenar
