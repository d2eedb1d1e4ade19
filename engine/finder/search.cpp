// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "collision/blue_noise.h"
#include "engine/finder/carry.h"
#include "engine/finder/pressed_shape.h"
#include "engine/finder/rate.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr int kFitSteps = 30, kPolishSteps = 12, kPolished = 6, kJitters = 4;
constexpr int kWider = 3;  // Factor on the usual number of fits for more than one grasp.
constexpr double kLeastMargin = 0.0;
constexpr double kRoughReach_m = 10e-3;  // A fit moves the hand by less, and may take it out of the environment.

/// An opposition of the hand matched with one of the object.
struct Start {
  Stance stance;
  const Opposition* pair;
  const Pinch* pinch;
  double cost;
};

/// Returns the rotation of the first of two unit vectors into the second.
Matrix3d turn(const Vector3d& from, const Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

class Search {
 public:
  Search(const FinderProblem& problem, const Hand& hand, const FinderSettings& settings, const FinderProgress& progress,
         FinderReport& report)
      : problem_(problem),
        hand_(hand),
        settings_(settings),
        progress_(progress),
        report_(report),
        body_(hand_body(hand)),
        fit_(hand, body_, problem.object),
        uniform_(settings.seed) {}

  SearchEvidence run() {
    evidence_.range = find_pinches(hand_, settings_.seed, settings_.effort);
    if (evidence_.range.opposer < 0) return evidence_;
    loads_N_ = expected_loads_N(problem_, hand_, evidence_.range.opposer);
    if (!look(1) && settings_.second_look && !report_.cancelled) look(4);
    return evidence_;
  }

 private:
  /// Runs one search, so many times as long as usual. True if it ends the search.
  bool look(int factor) {
    const int opposer = evidence_.range.opposer;
    const int effort = factor * settings_.effort;
    double widest_m = 0.0;
    for (int k = 0; k < hand_.fingers(); ++k) {
      widest_m = std::max(widest_m, pressed_radius_m(problem_.material, hand_.fingertips[k], loads_N_[k]));
    }
    const PatchMeter patches(problem_.object, widest_m);
    OppositionSettings wanted;
    // With some of the cone left for the weight.
    wanted.cone_rad = 0.9 * std::atan(problem_.friction);
    const double radius_m = hand_.fingertips[opposer].radius_m;
    const double depth_m = pressed_depth_m(problem_.material, hand_.fingertips[opposer], loads_N_[opposer]);
    wanted.least_m = 0.0;
    wanted.most_m = evidence_.range.most_m + 2.0 * depth_m + 6e-3;
    wanted.reach_m = radius_m - depth_m;
    wanted.centre_of_mass_m = problem_.centre_of_mass_m;
    wanted.wish = problem_.wish;
    wanted.places = std::min(1500, 160 * effort);
    wanted.pairs = std::min(1500, 48 * effort);
    wanted.seed = settings_.seed + static_cast<std::uint32_t>(factor);
    evidence_.oppositions = find_oppositions(problem_.object, patches, wanted);
    std::vector<Start> starts = starts_of(factor);
    refine(starts, std::min(3000, (settings_.best > 1 ? kWider : 1) * 28 * effort), patches);
    if (!found_.empty()) polish(patches);
    carry_best(patches);
    report_.grasps.insert(report_.grasps.end(), found_.begin(), found_.end());
    return !found_.empty();
  }

  /// Returns matches at all roll angles about the line of each pair, for the postures of about its width: the best
  /// first, a few per pair.
  std::vector<Start> starts_of(int factor) {
    const int rolls = factor > 1 ? 24 : 12;
    constexpr int kOfAPair = 3;
    std::vector<HandPose> poses(evidence_.range.postures.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      forward_kinematics(hand_, evidence_.range.postures[i].q, poses[i]);
    }
    std::vector<Start> starts;
    std::optional<HandReach> rough;
    for (const Opposition& pair : evidence_.oppositions.pairs) {
      std::vector<Start> of_pair;
      for (std::size_t i = 0; i < poses.size(); ++i) {
        const Pinch& pinch = evidence_.range.postures[i];
        if (!is_near(pair, pinch)) continue;
        const FitTarget target = target_of(pair, pinch);
        const double first = uniform_() * 2.0 * std::numbers::pi;
        for (int roll = 0; roll < rolls; ++roll) {
          const double angle = first + 2.0 * std::numbers::pi * roll / rolls;
          Start start{placed(pair, pinch, angle), &pair, &pinch, 0.0};
          const double enough =
              std::ssize(of_pair) < kOfAPair ? std::numeric_limits<double>::infinity() : worst(of_pair);
          start.cost = fit_.rough_cost(start.stance, poses[i], target, enough);
          if (start.cost < enough && has_room(start.stance, poses[i], kRoughReach_m, rough))
            keep(start, kOfAPair * (factor > 1 ? 2 : 1), of_pair);
        }
      }
      for (Start& start : of_pair) {
        start.cost += pair.cost + 0.02 * start.pinch->cost;
        starts.push_back(start);
      }
    }
    if (starts.empty() && !evidence_.least_reach) evidence_.least_reach = rough;
    std::sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.cost < b.cost; });
    return starts;
  }

  static double worst(const std::vector<Start>& starts) {
    return std::max_element(starts.begin(), starts.end(),
                            [](const Start& a, const Start& b) { return a.cost < b.cost; })
        ->cost;
  }
  static void keep(const Start& start, int most, std::vector<Start>& starts) {
    starts.push_back(start);
    if (std::ssize(starts) <= most) return;
    starts.erase(
        std::max_element(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.cost < b.cost; }));
  }

  [[nodiscard]] bool is_near(const Opposition& pair, const Pinch& pinch) const {
    // Pressed pulps are closer than undeformed ones.
    const double width_m = std::clamp(pair.width_m, evidence_.range.least_m, evidence_.range.most_m);
    return std::abs(pinch.width_m - width_m) <= 4.1e-3;
  }

  [[nodiscard]] Stance placed(const Opposition& pair, const Pinch& pinch, double roll_rad) const {
    const Vector3d u_O = (pair.to_O - pair.from_O) / pair.width_m;
    Stance stance{pinch.q, Isometry3d::Identity()};
    stance.X_WO.linear() = Eigen::AngleAxisd(roll_rad, pinch.axis) * turn(u_O, pinch.axis);
    stance.X_WO.translation() = pinch.middle_m - stance.X_WO.linear() * (0.5 * (pair.from_O + pair.to_O));
    return stance;
  }

  [[nodiscard]] FitTarget target_of(const Opposition& pair, const Pinch& pinch) const {
    FitTarget target;
    target.opposer = evidence_.range.opposer;
    target.depth_m = PerFinger<double>(hand_.fingers());
    for (int k = 0; k < hand_.fingers(); ++k) {
      target.depth_m[k] = pressed_depth_m(problem_.material, hand_.fingertips[k], loads_N_[k]);
    }
    target.opposer_O = pair.from_O;
    target.others_O = pair.to_O;
    target.q_near = pinch.q;
    target.approach_W = approach_of(hand_, pinch);
    target.wish = problem_.wish;
    target.centre_of_mass_m = problem_.centre_of_mass_m;
    return target;
  }

  void refine(const std::vector<Start>& starts, int most, const PatchMeter& patches) {
    const int count = std::min(most, static_cast<int>(starts.size()));
    for (int i = 0; i < count; ++i) {
      if (progress_ && !progress_(static_cast<double>(i) / count, static_cast<int>(found_.size()))) {
        report_.cancelled = true;
        return;
      }
      const FitTarget target = target_of(*starts[i].pair, *starts[i].pinch);
      try_stance(fit_.fit(starts[i].stance, target, kFitSteps), target, patches);
    }
  }

  /// Keeps the stance if it is a grasp, else its faults if they are less than any before.
  bool try_stance(const Stance& stance, const FitTarget& target, const PatchMeter& patches) {
    ++report_.fits;
    const FitFaults faults = fit_.faults(stance, target);
    if (!faults.none()) {
      if (evidence_.has_nearest && faults.badness() >= evidence_.nearest_faults.badness()) return false;
      evidence_.has_nearest = true;
      evidence_.nearest = stance;
      evidence_.nearest_target = target;
      evidence_.nearest_faults = faults;
      return false;
    }
    if (!has_room(stance)) return false;
    FoundGrasp grasp = rate(problem_, hand_, patches, stance, target, fit_);
    evidence_.best_margin = std::max(evidence_.best_margin, grasp.margin);
    if (!(grasp.margin > kLeastMargin)) return false;
    if (!std::isfinite(grasp.cost)) {
      note_beyond_muscles(grasp);
      return false;
    }
    found_.push_back(grasp);
    targets_.push_back(target);
    return true;
  }

  /// Tests whether the hand reaches into the environment by no more than this; `least` keeps the least reach beyond it.
  bool has_room(const Stance& stance, const HandPose& pose, double most_m, std::optional<HandReach>& least) const {
    if (problem_.environment == nullptr) return true;
    const double enough_m = least ? least->depth_m : std::numeric_limits<double>::infinity();
    const HandReach reach =
        hand_reach(*problem_.environment, hand_, body_, pose, stance.X_WO, std::max(enough_m, most_m));
    if (reach.depth_m <= most_m) return true;
    if (reach.depth_m < enough_m) least = reach;
    return false;
  }
  bool has_room(const Stance& stance) {
    if (problem_.environment == nullptr) return true;
    HandPose pose;
    forward_kinematics(hand_, stance.q, pose);
    return has_room(stance, pose, 0.0, evidence_.least_reach);
  }

  /// Notes a grasp whose torques no muscle forces give, at rest or wherever it carries the object.
  void note_beyond_muscles(const FoundGrasp& grasp) {
    std::optional<FoundGrasp>& best = evidence_.beyond_muscles;
    if (!best || grasp.margin > best->margin) best = grasp;
  }

  /// Refines the best with depths by their forces, and from contacts around them.
  void polish(const PatchMeter& patches) {
    std::vector<std::size_t> order(found_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return found_[a].cost < found_[b].cost; });
    order.resize(std::min<std::size_t>(order.size(), static_cast<std::size_t>(kPolished * settings_.effort)));
    for (const std::size_t i : order) {
      const FoundGrasp grasp = found_[i];
      FitTarget target = targets_[i];
      target.opposer_O.reset();
      target.others_O.reset();
      target.q_near = grasp.q;
      for (int k = 0; k < hand_.fingers(); ++k) {
        const FingerPlace& place = grasp.places[k];
        const double normal_N = -(grasp.X_WO.linear() * place.normal_O).dot(place.force_W);
        target.depth_m[k] = pressed_depth_m(problem_.material, hand_.fingertips[k], normal_N);
      }
      for (int jitter = 0; jitter <= kJitters; ++jitter) {
        Stance stance{grasp.q, grasp.X_WO};
        if (jitter > 0) stance = jittered(stance);
        try_stance(fit_.fit(stance, target, kPolishSteps), target, patches);
      }
    }
  }

  /// Computes how far the best grasps carry their object, until some do: of each kind, if more than one is wanted. The
  /// others are dropped.
  void carry_best(const PatchMeter& patches) {
    constexpr int kMost = 24, kEnough = 6, kOfAKind = 2;
    constexpr double kFar_m = 20e-3;
    const bool kinds = settings_.best > 1;
    std::sort(found_.begin(), found_.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
    int looked = 0;
    std::vector<const FoundGrasp*> far;
    for (FoundGrasp& grasp : found_) {
      const auto is_alike = [&](const FoundGrasp* other) { return alike(grasp, *other); };
      if (kinds && std::count_if(far.begin(), far.end(), is_alike) == kOfAKind) continue;
      if (looked++ == (kinds ? 2 * kWider : 1) * kMost * settings_.effort) break;
      if (!kinds && std::ssize(far) == kEnough * settings_.effort) break;
      add_travel(problem_, hand_, patches, grasp);
      if (grasp.travel_W.isZero(0.0)) note_beyond_muscles(grasp);
      grasp.cost = cost_of(grasp);
      if (grasp.travel_m > kFar_m - 1e-9) far.push_back(&grasp);
    }
    std::erase_if(found_, [](const FoundGrasp& grasp) { return grasp.travel_W.isZero(0.0); });
  }

  [[nodiscard]] Stance jittered(const Stance& stance) {
    constexpr double kWay_m = 6e-3, kTurn_rad = 0.3;
    Unknowns step = Unknowns::Zero(stance.q.size() + 6);
    for (int i = 0; i < 3; ++i) {
      step[stance.q.size() + i] = kWay_m * (2.0 * uniform_() - 1.0);
      step[stance.q.size() + 3 + i] = kTurn_rad * (2.0 * uniform_() - 1.0);
    }
    // About where the object is held, not about its origin.
    const Vector3d centre_m = stance.X_WO * problem_.object.bounds().center();
    step.segment<3>(stance.q.size()) += step.tail<3>().cross(Vector3d(stance.X_WO.translation() - centre_m));
    return moved(hand_, stance, step, true);
  }

  const FinderProblem& problem_;
  const Hand& hand_;
  const FinderSettings& settings_;
  const FinderProgress& progress_;
  FinderReport& report_;
  std::vector<BodyPoint> body_;
  StanceFit fit_;
  Uniform uniform_;
  PerFinger<double> loads_N_;
  SearchEvidence evidence_;
  std::vector<FoundGrasp> found_;
  std::vector<FitTarget> targets_;
};

}  // namespace

SearchEvidence search(const FinderProblem& problem, const Hand& hand, const FinderSettings& settings,
                      const FinderProgress& progress, FinderReport& report) {
  return Search(problem, hand, settings, progress, report).run();
}

}  // namespace thenar
