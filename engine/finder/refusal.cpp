#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "engine/finder/pinch.h"
#include "engine/finder/rate.h"
#include "engine/finder/search.h"

namespace thenar {

namespace {

/// With so many digits behind the point.
std::string number(double value, int digits = 0) {
  std::ostringstream text;
  text << std::fixed;
  text.precision(digits);
  text << value;
  return text.str();
}

std::string mm(double length_m, int digits = 0) { return number(1e3 * length_m, digits) + " mm"; }
std::string degrees(double angle_rad) { return number(angle_rad * 180.0 / std::numbers::pi) + " degrees"; }

/// Where a joint would have to go, if the nearest miss had no limits.
Refusal of_joints(const FinderProblem& problem, const Hand& hand, const SearchEvidence& evidence) {
  FitTarget target = evidence.nearest_target;
  target.limits = false;
  const std::vector<BodyPoint> body_points = hand_body(hand);
  StanceFit fit(hand, body_points, problem.object);
  const Stance free = fit.fit(evidence.nearest, target, 30);
  int worst = -1;
  double over_rad = 0.0;
  for (int i = 0; i < static_cast<int>(hand.joints.size()); ++i) {
    const Joint& joint = hand.joints[i];
    const double over = std::max(free.q[i] - joint.upper_rad, joint.lower_rad - free.q[i]);
    if (over <= over_rad) continue;
    over_rad = over;
    worst = i;
  }
  if (worst < 0) {
    return {"no posture brings all pulps to the object: the nearest one is " + mm(evidence.nearest_faults.gap_m, 1) +
                " off",
            ""};
  }
  const Joint& joint = hand.joints[worst];
  const double limit_rad = free.q[worst] > joint.upper_rad ? joint.upper_rad : joint.lower_rad;
  return {
      joint.name + " would have to bend to " + degrees(free.q[worst]) + ", and " + degrees(limit_rad) + " is its limit",
      "an object of another size, or other fingers"};
}

/// What the nearest miss lacked.
Refusal of_nearest(const FinderProblem& problem, const Hand& hand, const SearchEvidence& evidence) {
  const FitFaults& faults = evidence.nearest_faults;
  // The fault that is largest by the measure of FitFaults::badness().
  FitFaults one;
  const auto worth = [&](auto member) {
    FitFaults alone = one;
    alone.*member = faults.*member;
    return alone.badness();
  };
  const double limit = std::max(worth(&FitFaults::limit_rad), worth(&FitFaults::gap_m));
  const double body = worth(&FitFaults::body_m), apart = worth(&FitFaults::apart_m);
  const double bones = worth(&FitFaults::bones_m), facing = worth(&FitFaults::facing_rad);
  const double wish = worth(&FitFaults::axis_rad) + worth(&FitFaults::at_m) + worth(&FitFaults::approach_rad);
  const double most = std::max({limit, body, apart, bones, facing, wish});
  if (wish == most) {
    return {"no grasp as it is wished for was found: the nearest is beyond what passes for it by " +
                degrees(faults.axis_rad) + " of the axis, " + mm(faults.at_m) + " of the place and " +
                degrees(faults.approach_rad) + " of the approach",
            "leave out one of grasp.axis, grasp.at and grasp.approach"};
  }
  if (apart == most) {
    return {
        "the fingers would have to be " + mm(faults.apart_m, 1) + " in one another: the object is too small for " +
            std::to_string(hand.fingers()) + " pulps",
        hand.fingers() > 3 ? "name fewer fingers in grasp.fingers" : "a larger object, or a hand with smaller pulps"};
  }
  if (bones == most) {
    const int a = faults.bones_finger, b = faults.bones_other;
    const bool swap = a == evidence.range.opposer;  // It is the thumb that is passed through.
    return {"the " + hand.fingertips[swap ? b : a].finger + " would have to pass through the " +
                hand.fingertips[swap ? a : b].finger + ", by " + mm(faults.bones_m, 1),
            "an object of another size, or fewer fingers in grasp.fingers"};
  }
  if (body == most) {
    const std::string bone =
        faults.body_segment < 0 ? "palm" : hand.segments[static_cast<std::size_t>(faults.body_segment)].name;
    return {"the hand's " + bone + " would have to be " + mm(faults.body_m, 1) + " in the object",
            "a smaller object, or another place on it"};
  }
  if (facing == most) {
    return {"the pulp of the " + hand.fingertips[faults.facing_finger].finger + " would have to touch with its side, " +
                degrees(faults.facing_rad + kFacing_rad) + " off its middle",
            ""};
  }
  return of_joints(problem, hand, evidence);
}

}  // namespace

Refusal refusal_of(const FinderProblem& problem, const Hand& hand, const SearchEvidence& evidence) {
  const PinchRange& range = evidence.range;
  const Oppositions& seen = evidence.oppositions;
  if (range.opposer < 0) {
    return {"no finger can face the others: the best one stays " + degrees(range.best_facing_rad) + " off",
            "a hand whose thumb opposes"};
  }
  if (seen.places == 0) {
    return {"no place of the object is as wide and smooth as a pressed pulp's patch, for it is " +
                mm(problem.object.bounds().sizes().maxCoeff(), 1) + " across",
            "a larger object, less press, or harder pulps"};
  }
  if (seen.least_width_m == 0.0) {
    return {"no two surfaces face each other within the friction cones of mu " + number(problem.friction, 2),
            seen.least_angle_rad < 1.2
                ? "a friction of " + number(std::ceil(100.0 * std::tan(seen.least_angle_rad / 0.9)) / 100.0, 2) +
                      " would do"
                : ""};
  }
  if (!seen.fits) {
    return {"the object is " + mm(seen.least_width_m) +
                " wide where it is narrowest between faces, and this hand opens " + mm(range.most_m),
            "a larger hand or a smaller object"};
  }
  if (seen.pairs.empty()) {
    return {"no two surfaces face each other where grasp.axis and grasp.at want the fingers", "leave one of them out"};
  }
  if (evidence.best_margin > -1.0 || (!evidence.has_nearest && evidence.best_margin <= 0.0)) {
    return {
        "grasps fit, but none holds the weight in all directions, a push of 0.5 N and a turn of 10 mN m within the "
        "friction cones",
        "more friction, or more press"};
  }
  return of_nearest(problem, hand, evidence);
}

}  // namespace thenar
