// SPDX-License-Identifier: Apache-2.0
#include "engine/studies/model_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "engine/grasp/pulp_touch.h"
#include "engine/loops/percentiles.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"

namespace thenar {

namespace {

constexpr double kRadian_deg = 180.0 / std::numbers::pi;
constexpr int kCoarsest = 8;  // Coarsest contact.level.
// The controller's model of a rigid fingertip, as in configs/minimal.yaml: stiff enough.
constexpr double kRigidNormal_N_per_m = 50e3, kRigidTangential_N_per_m = 33.3e3;
// Negligible change: rounding, or the error of a contact solve that stops at a residual of 1e-6.
constexpr Tolerance kNoChange{1e-9, 1e-7, 1e-6, 1e-6, 1e-6};

void leave_out_touch(Scene& scene) {
  if (scene.fingertips) scene.fingertips->touch.reset();
  if (!scene.control) return;
  scene.control->reflex.reset();  // They need it.
  scene.control->felt_margin.reset();
}

void leave_out_fingertips(Scene& scene) {
  leave_out_touch(scene);
  scene.fingertips.reset();
  scene.object.compliance.reset();  // It needs deformable ones.
  scene.contact.max_per_finger = 1;
  scene.contact.level = 0;
  if (auto& control = scene.control) {
    control->pulp_normal_N_per_m = std::max(control->pulp_normal_N_per_m, kRigidNormal_N_per_m);
    control->pulp_tangential_N_per_m = std::max(control->pulp_tangential_N_per_m, kRigidTangential_N_per_m);
  }
}

/// Returns the sphere that touches the plane across the pulp's normal at the same point, with about the same
/// compliance.
void make_spherical(Fingertip& tip) {
  if (!tip.shape) return;
  const double radius_m = round_radius_m(tip);
  tip.centre_m += support_m(*tip.shape, tip.normal) - radius_m * tip.normal;
  tip.radius_m = radius_m;
  tip.shape.reset();
}

/// The data of a part.
struct PartTraits {
  const char* words;
  bool (*has)(const Scene&);
  void (*leave_out)(Scene&);  ///< Removes it from a scene that has it.
};
// In the order of Part.
constexpr std::array<PartTraits, kParts.size()> kTraits{{
    {"deformation of the fingertips (fingertips)", [](const Scene& s) { return s.fingertips.has_value(); },
     leave_out_fingertips},
    {"deformation of the object (object.compliance)", [](const Scene& s) { return s.object.compliance.has_value(); },
     [](Scene& s) { s.object.compliance.reset(); }},
    {"level of detail (contact.level)",
     [](const Scene& s) { return s.fingertips && s.contact.level && *s.contact.level < kCoarsest; },
     [](Scene& s) { ++*s.contact.level; }},
    {"muscles (control.muscles)", [](const Scene& s) { return s.has_muscles(); },
     [](Scene& s) { s.control->muscles.reset(); }},
    {"memory of the object (object.compliance.relaxation)",
     [](const Scene& s) { return s.object.compliance && s.object.compliance->relaxation_s > 0.0; },
     [](Scene& s) { s.object.compliance->relaxation_s = 0.0; }},
    {"memory of the fingertips (fingertips.relaxation)",
     [](const Scene& s) {
       return s.fingertips && std::ranges::any_of(s.hand.fingertips, [&](const Fingertip& tip) {
                return tip.relaxation_s.value_or(s.fingertips->material.relaxation_s) > 0.0;
              });
     },
     [](Scene& s) {
       s.fingertips->material.relaxation_s = 0.0;
       for (Fingertip& tip : s.hand.fingertips) tip.relaxation_s.reset();
     }},
    {"stiffening (fingertips.stiffening)",
     [](const Scene& s) { return s.fingertips && s.fingertips->material.stiffening_per_N > 0.0; },
     [](Scene& s) { s.fingertips->material.stiffening_per_N = 0.0; }},
    {"shape of the pulps (the hand's semi_axes and length)",
     [](const Scene& s) {
       return std::ranges::any_of(s.hand.fingertips, [](const Fingertip& tip) { return tip.shape.has_value(); });
     },
     [](Scene& s) {
       for (Fingertip& tip : s.hand.fingertips) make_spherical(tip);
     }},
    {"touch (fingertips.touch)", [](const Scene& s) { return s.fingertips && s.fingertips->touch; }, leave_out_touch},
    {"reflex (control.reflex)", [](const Scene& s) { return s.control && s.control->reflex; },
     [](Scene& s) { s.control->reflex.reset(); }},
    {"anticipation (control.anticipation)", [](const Scene& s) { return s.control && s.control->anticipation; },
     [](Scene& s) { s.control->anticipation = false; }},
    {"delay of what is known (control.feedback_delay)",
     [](const Scene& s) { return s.control && s.control->feedback_delay_s > 0.0; },
     [](Scene& s) { s.control->feedback_delay_s = 0.0; }},
    {"stiffness of the muscles (control.muscles.stiffness)",
     [](const Scene& s) { return s.has_muscles() && s.control->muscles->short_range; },
     [](Scene& s) {
       s.control->muscles->short_range.reset();
       s.control->muscles->object_stiffness.reset();
     }},
    {"activation of the muscles (control.muscles.activation)",
     [](const Scene& s) { return s.has_muscles() && s.control->muscles->activation; },
     [](Scene& s) { s.control->muscles->activation.reset(); }},
    {"environment (environment)", [](const Scene& s) { return s.environment.has_value(); },
     [](Scene& s) { s.environment.reset(); }},
}};

/// Formats two digits; negligible values are 0.
std::string brief(double value) {
  if (value < 1e-3) return "0";
  return value < 10.0 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value);
}

double square(double x) { return x * x; }
double rms(double squares, double count) { return count > 0.0 ? std::sqrt(squares / count) : 0.0; }
/// Returns a relative rms error; infinite where the reference is zero.
double share(double squares, double reference) {
  if (squares <= 0.0) return 0.0;
  return reference > 0.0 ? std::sqrt(squares / reference) : std::numeric_limits<double>::infinity();
}

/// Returns a tick's share of the median control tick, plus the median contact tick.
double tick_us(const Scene& scene, const Recording& recording) {
  std::vector<double> contact_s, control_s;
  for (const TickRecord& tick : recording.ticks) {
    contact_s.push_back(tick.contact.assemble_s + tick.contact.solve_s + tick.contact.deform_s);
    if (tick.controlled) control_s.push_back(tick.control_s);
  }
  const double share = std::min(1.0, scene.step_s / scene.control_period_s);
  return 1e6 * (percentiles(contact_s).p50 + share * percentiles(control_s).p50);
}

/// Returns the first measured tick; a scene that ends before is measured from its start.
std::size_t first_measured(const Scene& scene) {
  return scene.duration_s > kMeasuredFrom_s ? std::lround(kMeasuredFrom_s / scene.step_s) : 0;
}

bool is_within(const PathDeviation& error, const Tolerance& tolerance) {
  const auto small = [](double value, double allowed, double nothing) { return value <= std::max(allowed, nothing); };
  return small(error.position_rms_m, tolerance.position_m, kNoChange.position_m) &&
         small(error.position_final_m, tolerance.position_m, kNoChange.position_m) &&
         small(error.rotation_rms_rad, tolerance.rotation_rad, kNoChange.rotation_rad) &&
         small(error.rotation_final_rad, tolerance.rotation_rad, kNoChange.rotation_rad) &&
         small(error.force, tolerance.force, kNoChange.force) &&
         small(error.moment, tolerance.moment, kNoChange.moment) &&
         small(error.margin, tolerance.margin, kNoChange.margin);
}

PartEffect effect_of(Part part, const Scene& without, const Model& model, const PathRun& full) {
  const PathRun run = run_path(build_model(without, model));
  PartEffect effect{part, without.contact.level.value_or(0), run.verdict,
                    deviation(run.path, full.path, first_measured(model.scene)), run.us};
  effect.idle = part == Part::kEnvironment &&
                std::ranges::all_of(full.path.environment_N, [](const auto& force_N) { return force_N.isZero(0.0); });
  effect.alike = run.ended && run.verdict.outcome == full.verdict.outcome;
  effect.within = effect.alike && is_within(effect.error, model.scene.tolerance);
  return effect;
}

}  // namespace

const char* to_string(Part part) { return kTraits[static_cast<std::size_t>(part)].words; }

bool has(const Scene& scene, Part part) { return kTraits[static_cast<std::size_t>(part)].has(scene); }

Scene leave_out(Scene scene, Part part) {
  if (has(scene, part)) kTraits[static_cast<std::size_t>(part)].leave_out(scene);
  return scene;
}

bool GraspPath::see_tick(const Tick& tick) {
  X_WO.push_back(tick.after.X_WO);
  FingerForces& force = force_N.emplace_back(3, tick.after.load.size());
  for (Eigen::Index k = 0; k < force.cols(); ++k) force.col(k) = tick.after.load[k].force_N;
  patch.push_back(tick.contact.patch);
  environment_N.emplace_back(tick.contact.environment.wrench.head<3>());
  return true;
}

PathDeviation deviation(const GraspPath& path, const GraspPath& reference, std::size_t first) {
  PathDeviation off;
  double squares_m2 = 0.0, squares_rad2 = 0.0, squares_N2 = 0.0, reference_N2 = 0.0, ticks = 0.0;
  double moment2 = 0.0, limit2 = 0.0, margin2 = 0.0, margins = 0.0;
  for (std::size_t i = first; i < std::min(path.X_WO.size(), reference.X_WO.size()); ++i) {
    off.position_final_m = (path.X_WO[i].translation() - reference.X_WO[i].translation()).norm();
    off.rotation_final_rad =
        Eigen::Quaterniond(path.X_WO[i].linear()).angularDistance(Eigen::Quaterniond(reference.X_WO[i].linear()));
    squares_m2 += off.position_final_m * off.position_final_m;
    squares_rad2 += off.rotation_final_rad * off.rotation_final_rad;
    squares_N2 += (path.force_N[i] - reference.force_N[i]).squaredNorm();
    reference_N2 += reference.force_N[i].squaredNorm();
    squares_N2 += (path.environment_N[i] - reference.environment_N[i]).squaredNorm();
    reference_N2 += reference.environment_N[i].squaredNorm();
    for (std::size_t k = 0; k < path.patch[i].size(); ++k) {
      const PatchReport &patch = path.patch[i][k], &full = reference.patch[i][k];
      moment2 += square(patch.moment_Nm - full.moment_Nm);
      limit2 += square(full.moment_limit_Nm);
      const bool loaded = !std::isnan(patch.margin), loaded_in_full = !std::isnan(full.margin);
      if (!loaded && !loaded_in_full) continue;
      margin2 += loaded && loaded_in_full ? square(patch.margin - full.margin) : 1.0;
      ++margins;
    }
    ++ticks;
  }
  off.position_rms_m = rms(squares_m2, ticks);
  off.rotation_rms_rad = rms(squares_rad2, ticks);
  off.force = share(squares_N2, reference_N2);
  off.moment = share(moment2, limit2);
  off.margin = rms(margin2, margins);
  return off;
}

PathRun run_path(const Model& model) {
  PathRun run;
  State state(model);
  const Recording recording = run_scene(model, state, {.watchers = {&run.path}});
  run.verdict = recording.verdict;
  run.ended = !recording.stopped;
  run.us = tick_us(model.scene, recording);
  return run;
}

std::vector<PartEffect> ablate(const Model& model, const PathRun& full, const OnRun& on_run) {
  std::vector<PartEffect> effects;
  for (const Part part : kParts) {
    if (!has(model.scene, part)) continue;
    if (on_run) on_run(fmt::format("without {}", to_string(part)));
    effects.push_back(effect_of(part, leave_out(model.scene, part), model, full));
  }
  return effects;
}

NeededParts needed_parts(const Model& model, const PathRun& full, const OnRun& on_run) {
  NeededParts needed{model.scene, {}};
  for (const Part part : kParts) {
    // Detail may be reduced further.
    while (has(needed.scene, part)) {
      if (on_run) on_run(fmt::format("all together, also without {}", to_string(part)));
      Scene without = leave_out(needed.scene, part);
      const PartEffect effect = effect_of(part, without, model, full);
      const bool goes_on = effect.within && !needed.tried.empty() && needed.tried.back().part == part;
      if (goes_on) needed.tried.pop_back();
      needed.tried.push_back(effect);
      if (!effect.within) break;
      needed.scene = std::move(without);
    }
  }
  return needed;
}

std::string title(const PartEffect& effect) {
  return effect.part == Part::kDetail ? fmt::format("{} to {}", to_string(effect.part), effect.level)
                                      : to_string(effect.part);
}

std::string in_words(const PathDeviation& error) {
  return fmt::format("{} um, {} deg, forces {} %, moments {} %, margins {}", brief(1e6 * error.position_rms_m),
                     brief(kRadian_deg * error.rotation_rms_rad), brief(100.0 * error.force),
                     brief(100.0 * error.moment), brief(error.margin));
}

std::string in_words(const PartEffect& effect) {
  if (!effect.alike) return in_words(effect.verdict);
  if (effect.idle) return "nothing of it ever touches the object";
  return fmt::format("off by {} rms; {} um, {} deg at the end", in_words(effect.error),
                     brief(1e6 * effect.error.position_final_m), brief(kRadian_deg * effect.error.rotation_final_rad));
}

Model as_needed(Model model) {
  if (!model.scene.only_needed) return model;
  const PathRun full = run_path(model);
  if (fails(model.scene, full.verdict.outcome)) {
    model.scene.left_out = {"nothing left out, for the scene fails: " + in_words(full.verdict)};
    return model;
  }
  NeededParts needed = needed_parts(model, full);
  for (const PartEffect& effect : needed.tried) {
    needed.scene.left_out.push_back(
        fmt::format("{}: {}: {}", effect.within ? "left out" : "not left out", title(effect), in_words(effect)));
  }
  return build_model(std::move(needed.scene), model);
}

}  // namespace thenar
