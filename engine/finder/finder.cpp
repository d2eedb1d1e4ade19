// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/finder.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/finder/rate.h"
#include "engine/finder/search.h"

namespace thenar {

namespace {

/// Returns sets of fingers to try, each sorted: the wished one; or all, then all but one, and so on down to three.
std::vector<std::vector<int>> sets_of_fingers(const Hand& hand, const GraspWish& wish) {
  if (!wish.fingers.empty()) {
    std::vector<int> fingers = wish.fingers;
    std::sort(fingers.begin(), fingers.end());
    return {fingers};
  }
  std::vector<std::vector<int>> sets;
  const int all = hand.fingers();
  for (int size = all; size >= std::min(all, 3); --size) {
    for (int bits = (1 << all) - 1; bits > 0; --bits) {
      std::vector<int> fingers;
      for (int k = 0; k < all; ++k) {
        if ((bits >> (all - 1 - k)) % 2 == 1) fingers.push_back(k);
      }
      if (static_cast<int>(fingers.size()) == size) sets.push_back(fingers);
    }
  }
  return sets;
}

/// Tests whether two grasps have the same contacts.
bool same_places(const FoundGrasp& a, const FoundGrasp& b) {
  constexpr double kNear_m = 6e-3, kTurn_rad = 0.35;
  if (a.fingers != b.fingers) return false;
  double way_m = 0.0;
  for (std::size_t k = 0; k < a.places.size(); ++k) {
    way_m += (a.places[k].point_O - b.places[k].point_O).norm() / static_cast<double>(a.places.size());
  }
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(a.X_WO.linear().transpose() * b.X_WO.linear()));
  return way_m < kNear_m && turn.angle() < kTurn_rad;
}

/// Returns the best of each kind, and spare ones that are not the same.
void keep_best(const FinderSettings& settings, FinderReport& report) {
  std::sort(report.grasps.begin(), report.grasps.end(),
            [](const FoundGrasp& a, const FoundGrasp& b) { return a.cost < b.cost; });
  std::vector<FoundGrasp> kept;
  int best = 0, spare = 0;
  for (const FoundGrasp& grasp : report.grasps) {
    const auto any_is = [&](auto like) {
      return std::any_of(kept.begin(), kept.end(), [&](const FoundGrasp& other) { return like(grasp, other); });
    };
    if (best < settings.best && !any_is(alike)) {
      ++best;
    } else if (spare < settings.spare && !any_is(same_places)) {
      ++spare;
    } else {
      continue;
    }
    kept.push_back(grasp);
  }
  report.grasps = std::move(kept);
}

}  // namespace

FinderReport find_grasps(const FinderProblem& problem, const FinderSettings& settings, const FinderProgress& progress) {
  FinderReport report;
  const std::vector<std::vector<int>> sets = sets_of_fingers(problem.hand, problem.wish);
  if (sets.front().size() < 2) {
    report.refusal = {"one finger cannot hold an object: it needs another one that faces it",
                      problem.hand.fingers() > 1 ? "name more fingers in grasp.fingers" : "a hand with more fingers"};
    return report;
  }
  if (sets.front().size() == 2) {
    report.refusal = {
        "two fingers leave the turn about the line between them free: grasp forces act at a point of each, "
        "and hold no turn there",
        problem.hand.fingers() > 2 ? "a third finger in grasp.fingers" : "a hand with a third finger"};
    return report;
  }
  report.refusal = refusal_at_once(problem);
  if (report.refusal) return report;
  std::optional<Refusal> first;
  for (const std::vector<int>& fingers : sets) {
    const bool all = static_cast<int>(fingers.size()) == problem.hand.fingers();
    const Hand hand = all ? problem.hand : hand_of(problem.hand, fingers);
    FinderSettings part = settings;
    part.second_look = settings.second_look && sets.size() == 1;
    const SearchEvidence evidence = search(problem, hand, part, progress, report);
    for (FoundGrasp& grasp : report.grasps) {
      if (grasp.fingers.empty()) grasp.fingers = fingers;
    }
    if (!report.grasps.empty() || report.cancelled) break;
    // Fewer fingers may come nearer to a grasp: to one that only muscles do not give.
    if (first && (first->by_muscles || !evidence.beyond_muscles)) continue;
    first = refusal_of(problem, hand, evidence);
  }
  if (report.grasps.empty() && !report.cancelled) report.refusal = first;
  keep_best(settings, report);
  return report;
}

}  // namespace thenar
