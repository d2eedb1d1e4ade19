// SPDX-License-Identifier: Apache-2.0
#include "engine/results/warnings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/control/control.h"
#include "engine/formats/text.h"
#include "engine/grasp/pulp_touch.h"
#include "engine/grasp/small_contacts.h"
#include "engine/grasp/state.h"
#include "engine/hand/hand.h"
#include "engine/pulps/pressed_pulp.h"
#include "engine/pulps/pulp_levels.h"
#include "engine/results/grasp_monitor.h"
#include "engine/results/loop_words.h"

namespace thenar {

namespace {

// Left-out points are measured against the planes of the samples near them: on curved objects to some um.
constexpr double kNoticedDepth_m = 10e-6;

// A stop that bears less has just been met, or is about to be left.
constexpr double kNoticed_Nm = 1e-4;

// Of a pulp's force: about what its kernel errs by at the scenes' own levels.
constexpr double kNoticedShare = 0.01;

// Of the energy that drives bodies and is stored: what no reader of a ledger would pass over.
constexpr double kInjectedShare = 0.01, kNoticed_J = 1e-6;

// What is left of a balance that the solver's tolerance closes.
constexpr double kUnbalancedShare = 1e-3;

// Patches are told where more than half of them is Hertz's, or a paraboloid's; of a light touch all are narrow.
constexpr double kNoticedSmall = 0.5, kNoticed_N = 0.1;
constexpr const char* kNarrowPatch =
    "patch is narrower than its control points are apart: its force is Hertz's, and how friction and pressure lie "
    "in it is not resolved; more fingertips.leaves would serve";
constexpr const char* kSwallows =
    "pulp is pressed in by more than half of the object's radius of curvature: skin would close around it and "
    "bone bear it, and the model has neither, so that the force is uncertain";

/// Hertz's contact radius over the pulp's.
double patch_share(const Pulp& pulp, const Scene& scene, double normal_N) {
  return hertz_radius_m(pulp, normal_N, scene.object.compliance) / pulp.radius_m;
}

/// A controller that plans with friction that is not there; empty: it does not.
std::string friction_warning(const Scene& scene) {
  if (!scene.control || scene.control->felt_margin) return {};
  const double planned = scene.control->grasp_friction;
  const bool pyramids = scene.control->cone == FrictionCone::kPyramid;
  // At the corners of a pyramid the tangential force is sqrt(2) times that of its sides.
  const double most = (pyramids ? std::sqrt(2.0) : 1.0) * planned;
  if (!(most > scene.contact.friction)) return {};
  return fmt::format(
      "the controller plans with more friction than there is: control.grasp.friction is {:.3g}{}, contact.friction "
      "{:.3g}; "
      "fingers may slip",
      planned, pyramids ? fmt::format(", {:.3g} at the corners of its pyramids", most) : "", scene.contact.friction);
}

/// Fingers that a controller holds with and that nothing is near to; empty: there is none.
std::string reach_warning(const Model& model) {
  if (!model.scene.control) return {};
  const auto& phases = model.scene.task.phases;
  const bool comes =
      !phases.empty() && (phases.front().kind == Phase::Kind::kApproach || phases.front().kind == Phase::Kind::kClose);
  if (comes) return {};
  const State start(model);
  HandPose pose;
  forward_kinematics(model.scene.hand, start.q, pose);
  std::string all;
  for (int k = 0; k < model.fingers(); ++k) {
    const double gap_m = finger_gap_m(model, pose, start, k);
    if (!(gap_m > model.scene.contact.band_m)) continue;
    all += fmt::format("{}the {} is {:.3g} mm away from the object", all.empty() ? "" : ", ",
                       model.scene.hand.fingertips[k].finger, 1e3 * gap_m);
  }
  return all.empty() ? all : all + " at the start: the grasp needs all fingers";
}

/// Says which fibres have yielded, by how much, and when.
std::string fibre_warning(const Scene& scene, const YieldedFibres& worst, std::uint64_t all, double since_s,
                          double worst_s) {
  const std::vector<std::string> names = muscle_names(scene.hand, all);
  return fmt::format(
      "the fibres of {} were {} by {:.2g} % of their length at {:.3f} s, beyond the {:g} % within which their "
      "short-range stiffness holds; from {:.3f} s on {} yield: {}",
      scene.hand.muscles[static_cast<std::size_t>(worst.most)].name, worst.strain > 0.0 ? "stretched" : "shortened",
      100.0 * std::abs(worst.strain), worst_s, 100.0 * scene.control->muscles->short_range_strain, since_s,
      names.size() == 1 ? "these" : counted(std::ssize(names), "muscle"), fmt::join(names, ", "));
}

/// What fingers will press that is too small for their pulps, where they are nearest to the object at the start.
std::string small_warning(const Model& model) {
  const State start(model);
  HandPose pose;
  forward_kinematics(model.scene.hand, start.q, pose);
  for (int k = 0; k < model.fingers(); ++k) {
    const Fingertip& tip = model.scene.hand.fingertips[k];
    const Pulp& pulp = model.pulps[k];
    if (pulp.material.kernel == PulpKernel::kGaussian) continue;
    KnownSample known;
    const Eigen::Vector3d centre_O = start.X_WO.inverse() * (pose.distal(model.scene.hand, k) * tip.centre_m);
    const auto at = nearest_surface(model, centre_O, 2.0 * outer_radius_m(tip), known);
    if (!at) continue;
    const Eigen::Vector2d gap_per_m = relative_per_m(*at, tip.radius_m);
    if (!(gap_per_m.minCoeff() > 0.0)) continue;
    const double load_N = expected_load_N(model.scene, pulp), round_m = 1.0 / std::sqrt(gap_per_m.prod());
    const double depth_m = std::pow(0.75 * load_N / (pulp.material.reduced_modulus_Pa * std::sqrt(round_m)), 2.0 / 3.0);
    const SmallPatch small = small_patch(*at, tip.radius_m, std::sqrt(pulp.area_m2.mean()), depth_m);
    if (small.overhang > kNoticedSmall) return fmt::format("with {:.2g} N the {}'s {}", load_N, tip.finger, kSwallows);
    if (small.narrow > kNoticedSmall) return fmt::format("with {:.2g} N the {}'s {}", load_N, tip.finger, kNarrowPatch);
  }
  return {};
}

}  // namespace

void Warnings::Beyond::add(double time_s, double value) {
  if (ticks++ == 0) since_s = time_s;
  if (ticks > 1 && value <= worst) return;
  worst = value;
  worst_s = time_s;
}

double Warnings::share(std::size_t finger, double normal_N) const {
  return factor_[finger] * patch_share(model_.pulps[finger], model_.scene, normal_N);
}

void Warnings::Injected::add(const TickRecord& tick) {
  const Ledger& ledger = tick.contact.ledger;
  driven_J += std::abs(ledger.drive_J);
  stored_J = std::max(stored_J, ledger.stored_J);
  all_J += ledger.injected_J;
  unbalanced_J += ledger.unbalanced_J();
  for (std::size_t k = 0; k < tick.contact.injected_J.size(); ++k) fingers_J[k] += tick.contact.injected_J[k];
  const double share = all_J / (driven_J + stored_J);
  if (all_J > kNoticed_J && share > kInjectedShare) beyond.add(tick.time_s, share);
}

void Warnings::add(const TickRecord& tick) {
  ++ticks_;
  injected_.add(tick);
  for (std::size_t k = 0; k < model_.pulps.size(); ++k) {
    const double depth_m = tick.contact.left_out_m[k], normal_N = tick.force[k].normal_N;
    if (depth_m > kNoticedDepth_m) full_[k].add(tick.time_s, depth_m);
    if (share(k, normal_N) > kHalfSpaceShare) deep_[k].add(tick.time_s, normal_N);
    const SmallPatch& small = tick.contact.small[k];
    if (small.narrow > kNoticedSmall && normal_N > kNoticed_N) narrow_[k].add(tick.time_s, small.narrow);
    if (small.overhang > kNoticedSmall) swallowed_[k].add(tick.time_s, small.overhang);
  }
  if (const YieldedFibres& yielded = tick.contact.yielded; yielded.muscles != 0) {
    yield_ |= yielded.muscles;
    yielded_.add(tick.time_s, std::abs(yielded.strain));
    if (yielded_.worst_s == tick.time_s) worst_ = yielded;
  }
  for (Eigen::Index j = 0; j < tick.contact.stop_Nm.size(); ++j) {
    const double stop_Nm = tick.contact.stop_Nm[j];
    if (stop_Nm > kNoticed_Nm) stopped_[j].lower.add(tick.time_s, stop_Nm);
    if (stop_Nm < -kNoticed_Nm) stopped_[j].upper.add(tick.time_s, -stop_Nm);
  }
}

std::string Warnings::injected_in_words() const {
  const Beyond& beyond = injected_.beyond;
  const auto most = std::ranges::max_element(injected_.fingers_J);
  const bool by_finger = most != injected_.fingers_J.end() && *most >= 0.5 * injected_.all_J;
  const std::string where = by_finger
                                ? "at the " + model_.scene.hand.fingertips[most - injected_.fingers_J.begin()].finger
                                : "not at one finger alone";
  return fmt::format(
      "energy comes from nowhere: contacts have pushed bodies on by {:.3g} mJ, most of it {}; from {:.3f} s on that is "
      "more than {:g} % of what drives them and is stored, up to {:.3g} % at {:.3f} s. Late frames and edges cause "
      "this",
      1e3 * injected_.all_J, where, beyond.since_s, 100.0 * kInjectedShare, 100.0 * beyond.worst, beyond.worst_s);
}

std::string Warnings::balance_in_words() const {
  const double all_J = injected_.driven_J + injected_.stored_J, missing_J = std::abs(injected_.unbalanced_J);
  if (!std::isfinite(all_J) || !std::isfinite(missing_J)) {
    return "energies are not finite: forces or motions are beyond all that the model is good for";
  }
  if (!(missing_J > kNoticed_J && missing_J > kUnbalancedShare * all_J)) return {};
  return fmt::format(
      "the energy balance does not close: {:.3g} mJ are missing, {:.2g} % of what drives bodies and is stored. A "
      "shorter time.step, more of contact.max_sweeps or softer springs would serve",
      1e3 * missing_J, 100.0 * missing_J / all_J);
}

std::vector<std::string> Warnings::sentences() const {
  std::vector<std::string> all;
  if (const std::string friction = friction_warning(model_.scene); !friction.empty()) all.push_back(friction);
  for (std::size_t k = 0; k < model_.pulps.size(); ++k) {
    const std::string& finger = model_.scene.hand.fingertips[k].finger;
    if (const Beyond& full = full_[k]; full.ticks > 0) {
      all.push_back(fmt::format(
          "the {}'s list of contacts is too short (contact.max_per_finger: {}) in {:.3g} % of the ticks, from {:.3f} s "
          "on: control points without room pass up to {:.3g} mm into the object, and the force is too small; more "
          "room, "
          "or a coarser contact.level, would serve",
          finger, model_.scene.contact.max_per_finger,
          100.0 * static_cast<double>(full.ticks) / static_cast<double>(ticks_), full.since_s, 1e3 * full.worst));
    }
  }
  for (std::size_t k = 0; k < model_.pulps.size(); ++k) {
    if (const Beyond& deep = deep_[k]; deep.ticks > 0) {
      all.push_back(fmt::format(
          "the {}'s patch is wider than its pulp is good for, from {:.3f} s on: a / R = {:.2f} with {:.2f} N at {:.3f} "
          "s, of {:g} at most",
          model_.scene.hand.fingertips[k].finger, deep.since_s, share(k, deep.worst), deep.worst, deep.worst_s,
          kHalfSpaceShare));
    }
  }
  for (std::size_t k = 0; k < model_.pulps.size(); ++k) {
    const std::string& finger = model_.scene.hand.fingertips[k].finger;
    if (const Beyond& narrow = narrow_[k]; narrow.ticks > 0) {
      all.push_back(fmt::format("the {}'s {} (from {:.3f} s on)", finger, kNarrowPatch, narrow.since_s));
    }
    if (const Beyond& swallowed = swallowed_[k]; swallowed.ticks > 0) {
      all.push_back(fmt::format("the {}'s {} (from {:.3f} s on)", finger, kSwallows, swallowed.since_s));
    }
  }
  if (injected_.beyond.ticks > 0) all.push_back(injected_in_words());
  if (const std::string balance = balance_in_words(); !balance.empty()) all.push_back(balance);
  if (yielded_.ticks > 0) {
    all.push_back(fibre_warning(model_.scene, worst_, yield_, yielded_.since_s, yielded_.worst_s));
  }
  for (std::size_t j = 0; j < stopped_.size(); ++j) {
    const Joint& joint = model_.scene.hand.joints[j];
    for (const auto& [stop, end_rad] :
         {std::pair(&stopped_[j].lower, joint.lower_rad), std::pair(&stopped_[j].upper, joint.upper_rad)}) {
      if (stop->ticks == 0) continue;
      const bool slides = model_.scene.hand.slides;
      all.push_back(fmt::format(
          "the {} {} carries load at the end of its range, {:.4g} {}, from {:.3f} s on: up to {:.3g} {} at {:.3f} s",
          slides ? "slide" : "joint", joint.name, end_rad, slides ? "m" : "rad", stop->since_s, stop->worst,
          slides ? "N" : "N m", stop->worst_s));
    }
  }
  return all;
}

std::vector<std::string> warnings(const Model& model, const Recording& recording) {
  Warnings all(model);
  for (const TickRecord& tick : recording.ticks) all.add(tick);
  return all.sentences();
}

std::vector<std::string> warnings(const Model& model) {
  std::vector<std::string> all;
  const Scene& scene = model.scene;
  if (const std::string friction = friction_warning(scene); !friction.empty()) all.push_back(friction);
  if (const std::string reach = reach_warning(model); !reach.empty()) all.push_back(reach);
  for (const LoopMargin& margin : loop_margins(model)) {
    if (margin.is_near()) all.push_back(trouble_in_words(model, margin));
  }
  if (!model.deformable()) return all;
  const LevelEstimate used = estimate_level(scene, model.pulps, model.level);
  if (used.missing > kNoticedShare) {
    std::string text = fmt::format(
        "contact.max_per_finger: {} is too few: {} of {} control points carry the load expected, and without room for "
        "them up to {:.2g} % of the force is missing. {} would serve",
        scene.contact.max_per_finger, used.needed, used.controls, 100.0 * used.missing, used.needed);
    std::vector<Pulp> pulps = make_pulps(scene);
    const LevelEstimate better = choose_level(estimate_levels(scene, pulps), scene.contact.force_error);
    if (better.level != model.level && better.force_error < used.force_error) {
      text += fmt::format(", or contact.level: {} ({:.2g} % off)", better.level, 100.0 * better.force_error);
    }
    all.push_back(text);
  }
  if (const std::string small = small_warning(model); !small.empty()) all.push_back(small);
  double load_N = 0.0, share = 0.0;
  for (std::size_t k = 0; k < model.pulps.size(); ++k) {
    const double expected_N = expected_load_N(scene, model.pulps[k]);
    load_N = std::max(load_N, expected_N);
    share = std::max(share, share_factor(model.pulps[k], scene.hand.fingertips[k].normal) *
                                patch_share(model.pulps[k], scene, expected_N));
  }
  if (share > kHalfSpaceShare) {
    all.push_back(
        fmt::format("the load expected, {:.2g} N, makes patches wider than pulps are good for: a / R = {:.2f}, of "
                    "{:g} at most",
                    load_N, share, kHalfSpaceShare));
  }
  return all;
}

}  // namespace thenar
