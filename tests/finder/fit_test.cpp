// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/finder/pinch.h"
#include "tests/finder/known_surfaces.h"

namespace thenar::fit_test {
namespace {

using namespace known_surfaces;
using Eigen::Vector3d;

Stance some_stance(const Pinch& pinch) {
  Stance stance{pinch.q, Eigen::Isometry3d::Identity()};
  stance.X_WO.linear() = Eigen::AngleAxisd(0.4, Vector3d(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
  stance.X_WO.translation() = pinch.middle_m + Vector3d(1e-3, -2e-3, 1.5e-3);
  return stance;
}

FitTarget some_target(const Hand& hand, const Pinch& pinch) {
  FitTarget target;
  target.opposer = 0;
  target.depth_m = PerFinger<double>(hand.fingers(), 1e-3);
  target.q_near = pinch.q;
  target.approach_W = approach_of(hand, pinch);
  target.wish.axis_O = Vector3d::UnitX();
  target.wish.at_O = Vector3d(1e-3, 0.0, 2e-3);
  target.wish.approach_O = Vector3d::UnitZ();
  target.centre_of_mass_m = Vector3d(2e-3, 1e-3, 0.0);
  return target;
}

/// How far 2 J'r is from the slope of the sum of squares over steps of so many radians, at most over all unknowns, as a
/// share of the gradient's size.
double slope_error(StanceFit& fit, const Hand& hand, const Stance& stance, const FitTarget& target, double step_rad) {
  const NormalEquations at = fit.equations(stance, target);
  double worst = 0.0;
  const Eigen::Index joints = stance.q.size();
  for (Eigen::Index i = 0; i < at.Jr.size(); ++i) {
    const double lever_m = 0.02;  // Translations are weighed as rotations that make as much way.
    const double scale = i >= joints && i < joints + 3 ? lever_m : 1.0;
    Unknowns step = Unknowns::Zero(at.Jr.size());
    step[i] = step_rad * scale;
    const double up = fit.equations(moved(hand, stance, step, true), target).cost;
    const double down = fit.equations(moved(hand, stance, -step, true), target).cost;
    worst = std::max(worst, std::abs(2.0 * at.Jr[i] * scale - (up - down) / (2.0 * step_rad)));
  }
  Unknowns scaled = at.Jr;
  scaled.segment<3>(joints) *= 0.02;
  return worst / scaled.norm();
}

/// At the gaps that a stance has: there the factor by which far gaps count less is 1, and flat.
FitTarget as_deep_as(StanceFit& fit, const Hand& hand, const Stance& stance, FitTarget target) {
  for (int k = 0; k < hand.fingers(); ++k) target.depth_m[k] -= fit.touches(stance, target)[k].gap_m;
  return target;
}

double slope_error(const ImplicitSurface& object) {
  const Hand& hand = human_hand();
  const std::vector<BodyPoint> body = hand_body(hand);
  StanceFit fit(hand, body, object);
  const PinchRange range = find_pinches(hand, 1, 1);
  const Pinch& pinch = range.postures[range.postures.size() / 2];
  const FitTarget target = some_target(hand, pinch);
  FitTarget near = target;
  near.wish = {};
  const Stance stance = fit.fit(some_stance(pinch), near, 30);
  return slope_error(fit, hand, stance, as_deep_as(fit, hand, stance, target), 1e-3);
}

// The derivatives that the fit goes by are those of its residuals: the gradient of the sum of squares is 2 J'r, up to
// what differences over 1e-3 and kinks of hinges leave. On a ball of samples normals are rough: their derivatives are
// taken over 0.4 mm, and a tenth of the gradient is forgiven. A wrong sign or a missing term is more.
TEST(StanceFit, GoesByTheGradientOfItsSum) {
  EXPECT_LT(slope_error(box({0.04, 0.08, 0.08})), 0.03);
  EXPECT_LT(slope_error(ImplicitSurface(sample_sphere(0.02, 30000))), 0.1);
}

// So are those of bones in one another, in a posture by chance where they are, far from any object. The balance takes
// its lever as if it stayed, which is a percent here.
TEST(StanceFit, GoesByTheGradientOfBonesInOneAnother) {
  const Hand& hand = human_hand();
  const ImplicitSurface object = box({0.04, 0.4, 0.4});  // All pulps see one face.
  const std::vector<BodyPoint> body = hand_body(hand);
  const Bones bones = bones_of(hand, body);
  StanceFit fit(hand, body, object);
  std::mt19937_64 random(1);
  Stance stance{hand.at_zero(), Eigen::Isometry3d(Eigen::Translation3d(0.4, 0.0, 0.0))};
  HandPose pose;
  do {
    for (Eigen::Index i = 0; i < stance.q.size(); ++i) {
      const Joint& joint = hand.joints[static_cast<std::size_t>(i)];
      stance.q[i] = uniform(random, joint.lower_rad + 0.01, joint.upper_rad - 0.01);
    }
    forward_kinematics(hand, stance.q, pose);
  } while (overlap_of(bones, pose).depth_m < 2e-3);
  Pinch pinch;
  pinch.q = stance.q;
  FitTarget target = some_target(hand, pinch);
  target.wish = {};
  EXPECT_LT(slope_error(fit, hand, stance, as_deep_as(fit, hand, stance, target), 1e-5), 0.03);
}

// What it makes of a start some millimetres off are pulps at their depths.
TEST(StanceFit, ClosesGaps) {
  const Hand& hand = human_hand();
  const ImplicitSurface object = ball(0.02);
  const std::vector<BodyPoint> body = hand_body(hand);
  StanceFit fit(hand, body, object);
  const PinchRange range = find_pinches(hand, 1, 1);
  int tried = 0;
  for (const Pinch& pinch : range.postures) {
    if (std::abs(pinch.width_m - 0.04) > 5e-3) continue;
    FitTarget target = some_target(hand, pinch);
    target.wish = {};
    const Stance found = fit.fit(some_stance(pinch), target, 40);
    for (const FoundTouch& touch : fit.touches(found, target)) EXPECT_LT(std::abs(touch.gap_m), 0.1e-3);
    ++tried;
  }
  EXPECT_GT(tried, 0);
}

}  // namespace
}  // namespace thenar::fit_test
