// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/rate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/finder/carry.h"
#include "engine/finder/effort.h"
#include "engine/finder/hand_body.h"
#include "engine/finder/pinch.h"
#include "engine/finder/pressed_shape.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// Returns the least normal load of a finger.
double least_load_N(const std::vector<GraspContact>& contacts, const HoldingForces& forces) {
  double least_N = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    least_N = std::min(least_N, contacts[k].axes.col(0).dot(forces.f.segment<3>(3 * static_cast<Index>(k))));
  }
  return least_N;
}

/// Returns the lambda by which the least loaded finger presses with the wished load, if any, under the actual weight.
double internal_force_N(const FinderProblem& problem, const std::vector<GraspContact>& contacts,
                        const Eigen::Isometry3d& X_WO) {
  constexpr int kRounds = 8;
  if (!problem.wish.press_N) return problem.internal_force_N;
  const double press_N = *problem.wish.press_N;
  const Vector3d weight_N = problem.mass_kg * problem.gravity_at(X_WO);
  // With n fingers that share it evenly without weight, each except the opposer presses with 2 lambda / n.
  const double share = 0.5 * static_cast<double>(contacts.size());
  double lambda_N = share * press_N;
  for (int round = 0; round < kRounds; ++round) {
    ForceCheck check(problem, contacts, X_WO, lambda_N);
    const HoldingForces forces = check.against(weight_N, Vector3d::Zero());
    const double least_N = forces.found ? least_load_N(contacts, forces) : press_N;
    if (std::abs(least_N - press_N) < 0.01 * press_N) break;
    lambda_N = std::clamp(lambda_N + share * (press_N - least_N), 0.2 * lambda_N, 10.0 * press_N);
  }
  return lambda_N;
}

double margin_of(const FinderProblem& problem, const Eigen::Isometry3d& X_WO, ForceCheck& check) {
  double needed = 0.0;
  const double weight_N = problem.mass_kg * problem.gravity.norm();
  const double least_N = weight_N > 0.0 ? weight_N : 0.0;
  for (const Vector3d& e : directions()) {
    for (const double force_N : {least_N, least_N + kPush_N}) {
      needed = std::max(needed, check.against(force_N * e, Vector3d::Zero()).needed_friction);
      if (!std::isfinite(needed)) return -1.0;
    }
    needed = std::max(needed, check.against(problem.mass_kg * problem.gravity_at(X_WO), kTurn_Nm * e).needed_friction);
    if (!std::isfinite(needed)) return -1.0;
  }
  return 1.0 - needed / problem.friction;
}

void add_effort(const FinderProblem& problem, const Hand& hand, const std::vector<GraspContact>& contacts,
                ForceCheck& check, FoundGrasp& grasp) {
  Effort effort(problem, hand, contacts, grasp.X_WO);
  const Vector3d weight_N = problem.mass_kg * problem.gravity_at(grasp.X_WO);
  const auto add = [&](const Vector3d& force_N) {
    const HoldingForces forces = check.against(force_N, Vector3d::Zero());
    const JointVector tau = effort.torques_Nm(grasp.q, forces.f);
    grasp.muscle_share = std::max(grasp.muscle_share, effort.muscle_share(tau));
    return tau;
  };
  grasp.torque_Nm = add(weight_N).cwiseAbs().maxCoeff();
  if (!problem.muscles) return;
  for (const Vector3d& e : directions()) add(weight_N + kPush_N * e);
}

void add_limits(const Hand& hand, FoundGrasp& grasp) {
  grasp.limit_rad = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < grasp.q.size(); ++i) {
    const Joint& joint = hand.joints[i];
    const double left_rad = std::min(grasp.q[i] - joint.lower_rad, joint.upper_rad - grasp.q[i]);
    if (left_rad >= grasp.limit_rad) continue;
    grasp.limit_rad = left_rad;
    grasp.limit_joint = joint.name;
  }
}

}  // namespace

double cost_of(const FoundGrasp& grasp) {
  constexpr double kEnough = 0.6, kEasy_rad = 0.15, kHard = 0.5, kDexterous = 0.15;
  double cost = 1.0 - std::min(grasp.margin, kEnough) / kEnough + 0.5 * grasp.needed_friction;
  cost += 0.5 * std::max(0.0, 1.0 - grasp.limit_rad / kEasy_rad);
  cost += 2.0 * std::max(0.0, std::max(grasp.muscle_share, grasp.travel_share) - kHard) / kHard;
  const double dexterity = std::min(grasp.dexterity, grasp.travel_dexterity);
  cost += std::max(0.0, 1.0 - dexterity / kDexterous) + (dexterity < kLeastDexterity ? 5.0 : 0.0);
  cost += 0.1 * grasp.torque_Nm + 0.5 * grasp.travel_friction + 4.0 * std::max(0.0, 1.0 - grasp.travel_m / kCarry_m);
  for (const FingerPlace& place : grasp.places) {
    const double share = 1.0 / static_cast<double>(grasp.places.size());
    cost += share * (2.0 * (1.0 - place.patch) + 0.3 * std::pow(place.facing_rad / kFacing_rad, 2));
    cost += 2.0 * std::max(0.0, 0.8 - place.patch);
  }
  return cost;
}

PerFinger<double> expected_loads_N(const FinderProblem& problem, const Hand& hand, int opposer) {
  // f = lambda n, made to balance: the opposer has 2 (n - 1) / n of lambda, each other finger 2 / n.
  const double n = hand.fingers();
  const double lambda_N = problem.wish.press_N ? *problem.wish.press_N * n / 2.0 : problem.internal_force_N;
  const double weight_N = problem.mass_kg * problem.gravity.norm() / (2.0 * std::max(problem.cone_friction, 0.1));
  PerFinger<double> loads_N(hand.fingers(), std::max(2.0 / n * lambda_N, weight_N / std::max(1.0, n - 1.0)));
  loads_N[opposer] = std::max(2.0 * (n - 1.0) / n * lambda_N, weight_N);
  return loads_N;
}

FoundGrasp rate(const FinderProblem& problem, const Hand& hand, const PatchMeter& patches, const Stance& stance,
                const FitTarget& target, StanceFit& fit) {
  FoundGrasp grasp;
  grasp.opposer = target.opposer;
  grasp.q = stance.q;
  grasp.X_WO = stance.X_WO;
  grasp.approach_O = stance.X_WO.linear().transpose() * target.approach_W;
  grasp.places = PerFinger<FingerPlace>(hand.fingers());
  const PerFinger<FoundTouch> touches = fit.touches(stance, target);
  HandPose pose;
  forward_kinematics(hand, grasp.q, pose);
  Vector3d others_O = Vector3d::Zero();
  std::vector<GraspContact> contacts(hand.fingers());
  for (int k = 0; k < hand.fingers(); ++k) {
    FingerPlace& place = grasp.places[k];
    contacts[k] = pressed_contact(problem.object, grasp.X_WO, hand.fingertips[k], pose.distal(hand, k));
    place.point_O = grasp.X_WO.inverse() * contacts[k].point_m;
    place.normal_O = -(grasp.X_WO.linear().transpose() * contacts[k].axes.col(0));
    place.depth_m = target.depth_m[k] - touches[k].gap_m;
    place.facing_rad = std::acos(std::clamp(touches[k].cosine, -1.0, 1.0));
    place.patch = patches.share(place.point_O);
    grasp.dexterity = std::min(grasp.dexterity, dexterity(hand, pose, k, contacts[k].point_m));
    if (k != target.opposer) others_O += place.point_O / std::max(1, hand.fingers() - 1);
  }
  grasp.width_m = (others_O - grasp.places[target.opposer].point_O).norm();
  grasp.internal_force_N = internal_force_N(problem, contacts, grasp.X_WO);
  ForceCheck check(problem, contacts, grasp.X_WO, grasp.internal_force_N);
  const HoldingForces held = check.against(problem.mass_kg * problem.gravity_at(grasp.X_WO), Vector3d::Zero());
  grasp.needed_friction = held.needed_friction;
  grasp.margin = held.found ? margin_of(problem, grasp.X_WO, check) : -1.0;
  for (int k = 0; k < hand.fingers() && held.found; ++k) grasp.places[k].force_W = held.f.segment<3>(3 * k);
  add_limits(hand, grasp);
  if (held.found) add_effort(problem, hand, contacts, check, grasp);
  grasp.cost = held.found ? cost_of(grasp) : std::numeric_limits<double>::infinity();
  return grasp;
}

bool alike(const FoundGrasp& a, const FoundGrasp& b) {
  constexpr double kTurn_rad = 0.6, kShift_m = 12e-3, kApproach_rad = 0.7;
  if (a.fingers != b.fingers) return false;
  const auto line = [](const FoundGrasp& grasp) {
    Eigen::Vector3d others_O = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < grasp.places.size(); ++k) {
      if (static_cast<int>(k) == grasp.opposer) continue;
      others_O += grasp.places[k].point_O / static_cast<double>(grasp.places.size() - 1);
    }
    return std::pair{grasp.places[grasp.opposer].point_O, others_O};
  };
  const auto [from_a, to_a] = line(a);
  const auto [from_b, to_b] = line(b);
  return (to_a - from_a).normalized().dot((to_b - from_b).normalized()) > std::cos(kTurn_rad) &&
         (0.5 * (from_a + to_a) - 0.5 * (from_b + to_b)).norm() < kShift_m &&
         a.approach_O.dot(b.approach_O) > std::cos(kApproach_rad);
}

}  // namespace thenar
