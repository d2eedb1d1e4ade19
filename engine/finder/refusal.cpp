// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <sstream>

#include "engine/finder/effort.h"
#include "engine/finder/pinch.h"
#include "engine/finder/pressed_shape.h"
#include "engine/finder/rate.h"
#include "engine/finder/search.h"
#include "engine/hand/muscles.h"
#include "solvers/muscles/muscle_forces.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// Formats a number with so many decimals.
std::string number(double value, int digits = 0) {
  std::ostringstream text;
  text << std::fixed;
  text.precision(digits);
  text << value;
  return text.str();
}

std::string mm(double length_m, int digits = 0) { return number(1e3 * length_m, digits) + " mm"; }
std::string degrees(double angle_rad) { return number(angle_rad * 180.0 / std::numbers::pi) + " degrees"; }

/// Describes where a joint would have to go, if the nearest miss had no limits.
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

/// Describes the fault of the nearest miss.
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
    const bool swap = a == evidence.range.opposer;  // The thumb is the one that is penetrated.
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

/// Describes the body of the environment that is in the hand's way.
Refusal of_environment(const FinderProblem& problem, const Hand& hand, const HandReach& reach) {
  const std::string part = reach.finger < 0 ? "palm" : hand.fingertips[static_cast<std::size_t>(reach.finger)].finger;
  const std::string& name = problem.environment->bodies[static_cast<std::size_t>(reach.body)].name;
  return {"grasps fit, but '" + name + "' is in the hand's way: the " + part + " would have to be at least " +
              mm(reach.depth_m, 1) + " in it",
          "another grasp.approach, a grasp.at farther from it, or a smaller body of the environment"};
}

/// Describes the extent of a box.
std::string reach_of(const Eigen::AlignedBox3d& box) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text += (i > 0 ? ", " : "") + number(1e3 * box.min()[i]) + " .. " + number(1e3 * box.max()[i]);
  }
  return text + " mm in its frame";
}

/// Refuses loads under which pulps are indented beyond their law's validity, by a wish or by little friction.
std::optional<Refusal> of_loads(const FinderProblem& problem) {
  const int fingers = problem.wish.fingers.empty() ? std::min(3, problem.hand.fingers())
                                                   : static_cast<int>(problem.wish.fingers.size());
  double most_N = 0.0, radius_m = 0.0;  // Of the most loaded pulp.
  for (const Fingertip& tip : problem.hand.fingertips) {
    const double load_N = greatest_load_N(problem.material, tip);
    if (load_N <= most_N) continue;
    most_N = load_N;
    radius_m = tip.radius_m;
  }
  // The opposer bears what the others do.
  const double press_N = problem.wish.press_N ? (fingers - 1) * *problem.wish.press_N : 0.0;
  if (press_N > most_N) {
    return Refusal{"a press of " + number(*problem.wish.press_N, 1) + " N with each finger would take " +
                       number(press_N, 1) +
                       " N of the one that faces them, and its pulp is pressed in by half its "
                       "radius of " +
                       mm(radius_m, 1) + ", beyond which the engine has no law, under " + number(most_N, 1) + " N",
                   "a press of " + number(0.9 * most_N / (fingers - 1), 1) + " N or less, or harder pulps"};
  }
  const double friction = std::min(problem.friction, problem.cone_friction);
  const double weight_N = problem.mass_kg * problem.gravity.norm() + kPush_N;
  if (friction <= 0.0) {
    return Refusal{"without friction no fingers hold an object against its weight and a push of " + number(kPush_N, 1) +
                       " N in every direction",
                   "contact.friction and control.grasp.friction above 0"};
  }
  // Borne on two sides.
  if (weight_N > 2.0 * friction * most_N) {
    const double needed = 1.5 * weight_N / (2.0 * most_N) * problem.friction / friction;  // Of the contacts, with ease.
    const std::string cones = problem.cone_friction < problem.friction
                                  ? ", of which the controller plans with " + number(problem.cone_friction, 3) + ","
                                  : "";
    return Refusal{"at a friction of " + number(problem.friction, 2) + cones +
                       " the fingers would have to press with " + number(weight_N / (2.0 * friction), 1) +
                       " N on each side to bear the weight and a push of " + number(kPush_N, 1) + " N, and pulps of " +
                       mm(radius_m, 1) + " are pressed in by half their radius under " + number(most_N, 1) + " N",
                   needed < 2.0
                       ? "a friction of " + number(std::ceil(100.0 * needed) / 100.0, 2) + " or more, or less mass"
                       : "less mass"};
  }
  return std::nullopt;
}

/// Describes a remedy that gives fitting grasps some margin.
std::string help_of_margin(const FinderProblem& problem) {
  if (problem.cone_friction > problem.friction) {
    return "control.grasp.friction, " + number(problem.cone_friction, 2) + ", not above contact.friction, " +
           number(problem.friction, 2) + ": the controller trusts in more than there is";
  }
  return "more friction, or more press";
}

/// A joint, the limit to which its torque turns it, and the torque.
std::string needed_turn(const Hand& hand, Index i, double torque_Nm) {
  const Joint& joint = hand.joints[static_cast<std::size_t>(i)];
  return joint.name + " towards its limit of " + degrees(torque_Nm > 0.0 ? joint.upper_rad : joint.lower_rad) +
         ", where " + number(std::abs(torque_Nm), 3) + " N m are needed";
}

/// Describes the joints that no muscle turns the way of their torques, the largest first. Nothing if there are none.
std::string unturned_joints(const Hand& hand, const MuscleProblem& problem) {
  constexpr double kArm_m = 1e-7, kTorque_Nm = 5e-4;  // Smaller ones would be printed as zero.
  constexpr std::size_t kMost = 3;
  std::vector<Index> lacking;
  for (Index i = 0; i < problem.tau.size(); ++i) {
    const double sign = problem.tau[i] > 0.0 ? 1.0 : -1.0;
    if (std::abs(problem.tau[i]) >= kTorque_Nm && (sign * problem.H.row(i)).maxCoeff() < kArm_m) lacking.push_back(i);
  }
  std::ranges::sort(lacking, std::greater{}, [&](Index i) { return std::abs(problem.tau[i]); });
  std::string text;
  for (std::size_t i = 0; i < std::min(kMost, lacking.size()); ++i) {
    text += (i == 0 ? "no muscle turns " : ", nor ") + needed_turn(hand, lacking[i], problem.tau[lacking[i]]);
  }
  return lacking.size() > kMost ? text + ", nor " + number(static_cast<double>(lacking.size() - kMost)) + " more"
                                : text;
}

/// Describes the torque, of those that no muscle forces give, that is largest: `l` are joint velocities at which the
/// torques do work and no muscle does. Nothing if there is none.
std::string lacking_torque(const Hand& hand, const MuscleProblem& problem, const JointVector& l) {
  if (l.size() == 0 || l.isZero(0.0)) return "";
  const JointVector least_Nm = problem.tau.dot(l) / l.squaredNorm() * l;  // All torques that give tau.l are larger.
  Index worst = 0;
  least_Nm.cwiseAbs().maxCoeff(&worst);
  const double sign = least_Nm[worst] > 0.0 ? 1.0 : -1.0;
  std::string pulling;
  for (Index m = 0; m < problem.H.cols(); ++m) {
    constexpr double kArm_m = 1e-7;
    if (sign * problem.H(worst, m) < kArm_m) continue;
    pulling += (pulling.empty() ? "" : ", ") + hand.muscles[static_cast<std::size_t>(m)].name;
  }
  const std::string way = "turns " + needed_turn(hand, worst, least_Nm[worst]);
  return pulling.empty() ? "no muscle " + way : "what " + way + " (" + pulling + ") turns other joints too far";
}

/// Describes why no muscle forces give the torques of a grasp, under its weight or with a push.
Refusal of_muscles(const FinderProblem& problem, const Hand& hand, const FoundGrasp& grasp) {
  HandPose pose;
  forward_kinematics(hand, grasp.q, pose);
  std::vector<GraspContact> contacts(static_cast<std::size_t>(hand.fingers()));
  for (int k = 0; k < hand.fingers(); ++k) {
    contacts[static_cast<std::size_t>(k)] =
        pressed_contact(problem.object, grasp.X_WO, hand.fingertips[k], pose.distal(hand, k));
  }
  ForceCheck check(problem, contacts, grasp.X_WO, grasp.internal_force_N);
  Effort effort(problem, hand, contacts, grasp.X_WO);
  const Vector3d weight_N = problem.mass_kg * problem.gravity_at(grasp.X_WO);
  MuscleData data{Eigen::MatrixXd::Zero(grasp.q.size(), std::ssize(hand.muscles)), {}};
  moment_arms(hand, pose, data.H);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(std::ssize(hand.muscles));
  std::vector<Vector3d> pushes = directions();
  pushes.insert(pushes.begin(), Vector3d::Zero());
  std::string lack;
  for (const Vector3d& push : pushes) {
    data.tau = effort.torques_Nm(grasp.q, check.against(weight_N + kPush_N * push, Vector3d::Zero()).f);
    const MuscleReport report = solve_muscle_forces(data, f);
    if (report.status != MuscleStatus::kOptimal) lack = unturned_joints(hand, data);
    if (report.status != MuscleStatus::kOptimal && lack.empty()) lack = lacking_torque(hand, data, report.multiplier);
    if (!lack.empty()) break;
  }
  return {
      "grasps fit, and contact forces in the friction cones hold the object, but no muscle forces give the torques "
      "that these take" +
          (lack.empty() ? "" : ": " + lack),
      "muscles that do", true};
}

}  // namespace

std::optional<Refusal> refusal_at_once(const FinderProblem& problem) {
  const Eigen::AlignedBox3d& box = problem.object.bounds();
  if (const auto& at_O = problem.wish.at_O) {
    if (const double off_m = box.exteriorDistance(*at_O); off_m > problem.object.support_m()) {
      return Refusal{"grasp.at is " + mm(off_m, 1) + " away from the object, which reaches over " + reach_of(box),
                     "a place within that"};
    }
  }
  return of_loads(problem);
}

Refusal refusal_of(const FinderProblem& problem, const Hand& hand, const SearchEvidence& evidence) {
  const PinchRange& range = evidence.range;
  const Oppositions& seen = evidence.oppositions;
  if (range.opposer < 0) {
    return {"no finger can face the others: the best one stays " + degrees(range.best_facing_rad) + " off",
            "a hand whose thumb opposes"};
  }
  if (seen.places == 0) {
    return {"no place of the object is as wide and smooth as a pressed pulp's patch, for it is " +
                mm(problem.object.bounds().sizes().minCoeff(), 1) + " across where it is thinnest",
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
  // No grasp was rated, so each that fits reaches into the environment.
  if (evidence.least_reach && evidence.best_margin <= -1.0) {
    return of_environment(problem, hand, *evidence.least_reach);
  }
  if (evidence.beyond_muscles) return of_muscles(problem, hand, *evidence.beyond_muscles);
  if (evidence.best_margin > -1.0 || (!evidence.has_nearest && evidence.best_margin <= 0.0)) {
    return {
        "grasps fit, but none holds the weight in all directions, a push of 0.5 N and a turn of 10 mN m within the "
        "friction cones",
        help_of_margin(problem)};
  }
  return of_nearest(problem, hand, evidence);
}

}  // namespace thenar
