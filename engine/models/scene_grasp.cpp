// SPDX-License-Identifier: Apache-2.0
#include "engine/models/scene_grasp.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "engine/finder/hand_body.h"
#include "engine/finder/rate.h"
#include "engine/finder/rehearse.h"
#include "engine/finder/settle.h"
#include "engine/formats/text.h"
#include "engine/models/scene_environment.h"
#include "engine/models/surface_model.h"
#include "engine/scenes/config.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

/// J' f + g: what holds the fingers where they are while they press.
JointVector holding_torques(const FoundGrasp& grasp, const Scene& scene) {
  HandPose pose;
  forward_kinematics(scene.hand, grasp.q, pose);
  JointVector tau = gravity_torques(scene.hand, pose, scene.gravity);
  for (int k = 0; k < scene.hand.fingers(); ++k) {
    const Fingertip& tip = scene.hand.fingertips[k];
    const FingerJacobian J = finger_jacobian(scene.hand, pose, k, grasp.X_WO * grasp.places[k].point_O);
    tau.segment(tip.first_joint, tip.joints) += J.leftCols(tip.joints).transpose() * grasp.places[k].force_W;
  }
  return tau;
}

}  // namespace

FinderProblem finder_problem(const Scene& scene, const ImplicitSurface& object) {
  FinderProblem problem{.hand = scene.hand, .object = object};
  problem.mass_kg = scene.object.mass_kg;
  problem.centre_of_mass_m = scene.object.centre_of_mass_m;
  problem.translation_damping = scene.object.translation_damping;
  problem.gravity = scene.gravity;
  problem.gravity_in_object_frame = scene.gravity_in_object_frame;
  if (scene.environment && scene.environment->in_object_frame) problem.environment = &*scene.environment;
  problem.friction = problem.cone_friction = scene.contact.friction;
  if (scene.control) {
    problem.cone_friction = scene.control->grasp_friction;
    problem.cone = scene.control->cone;
    problem.internal_force_N = scene.control->internal_force_N;
  }
  if (scene.fingertips) problem.material = scene.fingertips->material;
  problem.muscles = scene.has_muscles();
  if (scene.grasp) problem.wish = *scene.grasp;
  return problem;
}

void take_grasp(const FoundGrasp& grasp, Scene& scene) {
  if (static_cast<int>(grasp.fingers.size()) < scene.hand.fingers()) scene.hand = hand_of(scene.hand, grasp.fingers);
  scene.posture = grasp.q;
  scene.settles = true;
  scene.object.X_WO = grasp.X_WO;
  place_by_object(scene);
  if (scene.control) {
    scene.control->internal_force_N = grasp.internal_force_N;
  } else {
    scene.torques = holding_torques(grasp, scene);
  }
  scene.grasp.reset();
}

namespace {

bool is_like_one(const FoundGrasp& grasp, const std::vector<FoundGrasp>& others) {
  return std::any_of(others.begin(), others.end(), [&](const FoundGrasp& other) { return alike(grasp, other); });
}

/// What would have kept an object that was lost.
std::string help_of(const Rehearsal& rehearsal) {
  return rehearsal.muscle_share > 1.0 || !rehearsal.weakness.empty()
             ? "less press or less mass, a place nearer to the centre of mass, or a stronger hand"
             : "more friction or press, less mass, or wider faces";
}

/// Grasps that fit are tried in the engine, all on one model as long as they use the same fingers.
class Trials {
 public:
  Trials(const Scene& scene, const ImplicitSurface& object, const FinderProgress& progress)
      : scene_(scene), object_(object), progress_(progress) {}

  /// Puts those in place of what was found that held with ease, after the `first` ones, each unlike the others, until
  /// there are `best`.
  void sift(const std::vector<FoundGrasp>& first, int best, FinderReport& report) {
    std::vector<FoundGrasp> kept = first;
    double rehearsed = 0.0;
    for (FoundGrasp& grasp : report.grasps) {
      if (std::ssize(kept) >= best || (kept.empty() && rehearsed > kMostRehearsed)) break;
      if (is_like_one(grasp, kept)) continue;
      // Who stops has what held until then: of what was found one is tried at least.
      if (progress_ && !progress_(1.0, static_cast<int>(kept.size() + hard_.size()))) report.cancelled = true;
      if (report.cancelled && (!kept.empty() || tried_ > 0)) break;
      rehearsed += rehearse(grasp);
      if (tried_++ == 0 || grasp.rehearsal.lasted > longest_.lasted) longest_ = grasp.rehearsal;
      if (!grasp.rehearsal.held() && (failed_++ == 0 || grasp.rehearsal.lasted > longest_failed_.lasted)) {
        longest_failed_ = grasp.rehearsal;
      }
      if (grasp.rehearsal.with_ease()) {
        kept.push_back(grasp);
      } else if (grasp.rehearsal.held()) {
        hard_.push_back(grasp);
      }
    }
    report.grasps = std::move(kept);
  }

  /// Whether some held, but not with ease.
  [[nodiscard]] bool has_hard() const { return !hard_.empty(); }

  /// Adds these after those that held with ease, up to `best`, by their strain; of none at all it tells why.
  void finish(int best, FinderReport& report) {
    std::ranges::sort(hard_, {}, [](const FoundGrasp& grasp) { return grasp.rehearsal.strain(); });
    for (const FoundGrasp& grasp : hard_) {
      if (std::ssize(report.grasps) < best && !is_like_one(grasp, report.grasps)) report.grasps.push_back(grasp);
    }
    report.refusal.reset();
    if (report.grasps.empty() && tried_ > 0) report.refusal = refusal();
    if (!report.grasps.empty() && std::ssize(report.grasps) < best && !report.cancelled) report.shortfall = shortfall();
  }

 private:
  static constexpr double kRestless = 0.05;      // Shares of a finger's load that settling leaves.
  static constexpr double kFine = 3.0;           // Trials of thin parts take so many times as long.
  static constexpr double kMostRehearsed = 2.5;  // So many whole ones: most that fail are over soon.

  /// Returns its length: 1 for a whole one.
  double rehearse(FoundGrasp& grasp) {
    Scene taken = scene_;
    take_grasp(grasp, taken);
    if (!model_ || fingers_ != grasp.fingers) {
      model_.emplace(surface_model(std::move(taken), object_));
      fingers_ = grasp.fingers;
    } else {
      model_->scene = std::move(taken);
      settle(*model_);
    }
    grasp.q = model_->scene.posture;
    grasp.rehearsal = thenar::rehearse(*model_, grasp);
    const double length = (model_->fine_m.cols() > 0 ? kFine : 1.0) * grasp.rehearsal.lasted;
    if (!grasp.rehearsal.held()) return length;
    grasp.needed_friction = grasp.rehearsal.needed_friction;
    // A scene of it settles from this posture on, and must come to rest there, too.
    if (settle(*model_) > kRestless) {
      grasp.rehearsal.lasted = 0.0;
      grasp.rehearsal.trouble = "its fingers find no rest";
    }
    return length;
  }

  /// Why there are no more.
  [[nodiscard]] std::string shortfall() const {
    const std::string others =
        "all others that fit hold with the same fingers, along about the same line and from about "
        "the same side";
    if (failed_ == 0) return others;
    return fmt::format("{} more failed when tried: in the one that lasted longest, {}; {}", counted(failed_, "grasp"),
                       longest_failed_.trouble, others);
  }

  [[nodiscard]] Refusal refusal() const {
    constexpr double kFarOrigin_m = 0.15;
    const std::string reason = fmt::format(
        "grasps fit, but none of {} held the object when it was tried: in the one that lasted longest, for "
        "{:.0f} % of the time, {}{}{}",
        tried_, 100.0 * longest_.lasted, longest_.trouble,
        longest_.weakness.empty() ? "" : ", where muscles are too weak: ", longest_.weakness);
    // Drag, and the errors of the controller, act at the origin of the object's frame: it must be no lever.
    const double off_m = object_.bounds().exteriorDistance(Vector3d::Zero().eval());
    if (off_m >= kFarOrigin_m) {
      return {reason + fmt::format("; the origin of its frame lies {:.2g} m outside it, where damping acts", off_m),
              "a file in whose object the origin lies"};
    }
    const bool tiny = object_.bounds().sizes().maxCoeff() < scene_.hand.fingertips.front().radius_m;
    return {reason, tiny ? "a larger object: this one is smaller than a pulp" : help_of(longest_),
            !longest_.weakness.empty()};
  }

  const Scene& scene_;
  const ImplicitSurface& object_;
  const FinderProgress& progress_;
  std::optional<Model> model_;
  std::vector<int> fingers_;
  std::vector<FoundGrasp> hard_;
  Rehearsal longest_, longest_failed_;
  int tried_ = 0, failed_ = 0;
};

/// The order in which grasps are tried after others failed. Whether a thin object will be held, it tells better than
/// the cost by which grasps are ranked.
double ease(const FoundGrasp& grasp) {
  constexpr double kCarry_m = 20e-3;
  return std::max(grasp.muscle_share, grasp.travel_share) + 0.2 * std::max(0.0, 1.0 - grasp.travel_m / kCarry_m);
}

/// One search, and trials; while none holds with ease, others with more spare grasps.
FinderReport search_and_try(const Scene& scene, const ImplicitSurface& object, const FinderSettings& settings,
                            const FinderProgress& progress, const std::vector<FoundGrasp>& first = {}) {
  constexpr int kSpare = 5, kMoreSpare = 14;  // So many more than wanted may fail.
  constexpr int kMostWanted = 20;             // For any number up to it the search is the same: ranks stay.
  constexpr int kAgain = 4, kAgainIfHard = 1;
  const FinderProblem problem = finder_problem(scene, object);
  // What the object stands on keeps the hand away; a trial carries the object anywhere.
  Scene tried = scene;
  if (problem.environment != nullptr) tried.environment.reset();
  FinderSettings now = settings;
  now.best = settings.best > 1 ? std::max(settings.best, kMostWanted) : 1;
  now.spare = kSpare;
  FinderReport report = find_grasps(problem, now, progress);
  if (report.grasps.empty()) return report;
  Trials trials(tried, object, progress);
  for (int again = 0;; ++again) {
    trials.sift(first, settings.best, report);
    if (!report.grasps.empty() || report.cancelled || again >= (trials.has_hard() ? kAgainIfHard : kAgain)) break;
    now.effort = 2 * settings.effort;
    now.seed += 100;
    now.spare = kMoreSpare;
    report = find_grasps(problem, now, progress);
    std::ranges::sort(report.grasps, {}, ease);
  }
  trials.finish(settings.best, report);
  return report;
}

/// The refusal of a grasp that muscles do not give, with whether joint torques would: where these hold nothing either,
/// their reason.
Refusal compared_with_torques(const Scene& scene, const ImplicitSurface& object, const FinderSettings& settings,
                              const FinderProgress& progress, const Refusal& by_muscles) {
  Scene by_torques = scene;
  by_torques.control->muscles.reset();
  const FinderReport report = search_and_try(by_torques, object, settings, progress);
  if (!report.grasps.empty()) {
    return {by_muscles.reason + ". Joint torques in place of muscles hold it",
            by_muscles.help + ", or control.muscles: false (a hand file with muscles: []), for torques", true};
  }
  if (report.cancelled || !report.refusal) return by_muscles;
  return {by_muscles.reason + ". By joint torques in place of muscles: " + report.refusal->reason, report.refusal->help,
          true};
}

}  // namespace

FinderReport find_tried_grasps(const Scene& scene, const ImplicitSurface& object, const FinderSettings& settings,
                               const FinderProgress& progress) {
  if (stands_in_object_frame(scene)) {
    Scene standing = scene;
    stand_object(standing, object);
    return find_tried_grasps(standing, object, settings, progress);
  }
  FinderSettings one = settings;
  one.best = 1;
  FinderReport report = search_and_try(scene, object, one, progress);
  if (report.refusal && report.refusal->by_muscles && !report.cancelled) {
    report.refusal = compared_with_torques(scene, object, one, progress, *report.refusal);
  }
  if (settings.best <= 1 || report.cancelled || report.grasps.empty()) return report;
  FinderReport wider = search_and_try(scene, object, settings, progress, report.grasps);
  // Where the wider search fits none there is what the first one found.
  if (!wider.grasps.empty()) return wider;
  report.cancelled = wider.cancelled;
  report.shortfall = "a wider search found no other";
  return report;
}

std::string find_scene_grasp(Scene& scene, const ImplicitSurface& object) {
  const GraspWish wish = scene.grasp.value_or(GraspWish{});
  const std::string& place = wish.place.empty() ? scene.name : wish.place;
  const FinderSettings settings{.seed = wish.seed, .best = wish.rank};
  const FinderReport report = find_tried_grasps(scene, object, settings);
  if (report.grasps.empty()) {
    throw ConfigError({{place, "grasp", report.refusal ? in_words(*report.refusal) : "no grasp was found"}});
  }
  if (static_cast<int>(report.grasps.size()) < wish.rank) {
    throw ConfigError(
        {{place, "grasp.rank",
          fmt::format("the search found {} only: {}", counted(std::ssize(report.grasps), "grasp"), report.shortfall)}});
  }
  const FoundGrasp& grasp = report.grasps[wish.rank - 1];
  std::string words = in_words(grasp, scene.hand);
  take_grasp(grasp, scene);
  return words;
}

std::string shown_number(const GraspMeasure& measure, const FoundGrasp& grasp) {
  return fmt::format("{:.{}f}", measure.shown_value(grasp), measure.digits);
}

namespace {

/// "index, major and ring": the fingers that the opposer faces.
std::string others_of(const FoundGrasp& grasp, const Hand& hand) {
  std::string others;
  for (std::size_t i = 0; i < grasp.fingers.size(); ++i) {
    if (static_cast<int>(i) == grasp.opposer) continue;
    others += (others.empty()                  ? ""
               : i + 1 == grasp.fingers.size() ? " and "
                                               : ", ") +
              hand.fingertips[grasp.fingers[i]].finger;
  }
  return others;
}

}  // namespace

std::string in_words(const FoundGrasp& grasp, const Hand& hand) {
  const auto shown = [&](std::string_view name) { return shown_number(grasp_measure(name), grasp); };
  double most_N = 0.0, deepest_m = 0.0;
  for (const FingerPlace& place : grasp.places) {
    most_N = std::max(most_N, press_N(grasp, place));
    deepest_m = std::max(deepest_m, place.depth_m);
  }
  std::string text = fmt::format(
      "the {} faces {} across {} mm. The fingers press with {} to {:.2f} N and are pressed in by up to {:.2f} mm. "
      "Under "
      "the weight as it is the grasp needs a friction of {}; with the weight in any direction, a push of 0.5 N and a "
      "turn of 10 mN m each friction cone keeps a margin of {}. ",
      hand.fingertips[grasp.fingers[grasp.opposer]].finger, others_of(grasp, hand), shown("width_m"), shown("press_N"),
      most_N, 1e3 * deepest_m, shown("needed_friction"), shown("margin"));
  text +=
      fmt::format("The nearest joint limit is that of {}, {} away; the largest torque is {} N m", grasp.limit_joint,
                  counted(std::lround(grasp_measure("limit_rad").shown_value(grasp)), "degree"), shown("torque_Nm"));
  if (grasp_measure("muscle_share").is_of(grasp)) {
    text += fmt::format(", for which a muscle gives up to {} % of what it can", shown("muscle_share"));
  }
  if (const double patch = grasp_measure("patch").value(grasp); patch < 0.9) {
    text += fmt::format(". A patch reaches over an edge: {:.0f} % of it touch", 100.0 * patch);
  }
  return text + ".";
}

std::string in_words(const Refusal& refusal) {
  return refusal.help.empty() ? refusal.reason : fmt::format("{}; what would help: {}", refusal.reason, refusal.help);
}

}  // namespace thenar
