// SPDX-License-Identifier: Apache-2.0
// The part "model" of the report: what each part of the model costs and how much error it removes, scene by scene, and
// what `model: auto` makes of it.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "bench/report/figure.h"
#include "engine/loops/percentiles.h"
#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "engine/scenes/scene_file.h"
#include "engine/studies/model_parts.h"

namespace thenar {
namespace {

using nlohmann::ordered_json;

constexpr double kRadian_deg = 180.0 / std::numbers::pi;

struct Case {
  std::string name, scene;
  std::vector<std::string> overrides = {};

  [[nodiscard]] Scene load(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), overrides.begin(), overrides.end());
    return load_scene(std::filesystem::path(THENAR_CONFIGS) / (scene + ".yaml"), more);
  }
};

const Case kBox{"box", "box_grasp"};
const Case kSlide{"sliding ball", "slide"};
const Case kCapsule{"handle", "capsule"};
const Case kMug{"mug", "mug"};
const Case kStick{"box on a spring", "stick"};
const Case kSoftBox{
    "soft box", "box_grasp", {"object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}"}};

std::vector<Case> cases(bool quick) {
  if (quick) return {kBox, kSlide, kCapsule, kSoftBox};
  std::vector<Case> all{kBox,
                        {"box, turned", "box_turn"},
                        {"box by its edges", "box_edge"},
                        {"thin plate", "thin_plate"},
                        kCapsule,
                        kMug,
                        kStick,
                        kSlide,
                        kSoftBox,
                        {"box, stiffening tips", "box_grasp", {"fingertips.stiffening=0.5 1/N"}}};
  const Case bunny{"bunny", "bunny"};
  if (std::filesystem::exists(std::get<CloudShape>(bunny.load().object.shape).file)) all.push_back(bunny);
  return all;
}

// --- the parts that have a key ---------------------------------------------------------------------------------------

struct Times {
  std::vector<double> median_us, spread;  ///< Of each model; spread: largest less smallest, over the median.
};

/// Times of models that are run in turns.
Times run_in_turns(const std::vector<Model>& models, int rounds) {
  std::vector<std::vector<double>> us(models.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < models.size(); ++i) us[i].push_back(run_path(models[i]).us);
  }
  Times times;
  for (auto& of_one : us) {
    const auto [least, most] = std::ranges::minmax(of_one);
    times.median_us.push_back(percentiles(std::move(of_one)).p50);
    times.spread.push_back((most - least) / times.median_us.back());
  }
  return times;
}

struct CaseResult {
  std::string name;
  double us = 0.0, auto_us = 0.0;
  std::vector<PartEffect> effects;  ///< With the times of runs in turns.
  std::vector<PartEffect> auto_parts;
  std::string failure;
  std::vector<double> spread;  ///< Of the times of each variant.
};

CaseResult measure(const Case& item, int rounds) {
  const Model model = build_model(item.load());
  const PathRun full = run_path(model);
  CaseResult result{item.name, full.us, full.us, {}, {}, {}, {}};
  if (fails(model.scene, full.verdict.outcome)) {
    result.failure = in_words(full.verdict);
    return result;
  }
  result.effects = ablate(model, full);
  const NeededParts needed = needed_parts(model, full);
  result.auto_parts = needed.tried;

  std::vector<Model> models{model, build_model(needed.scene, model)};
  for (const PartEffect& effect : result.effects)
    models.push_back(build_model(leave_out(model.scene, effect.part), model));
  const auto [us, spread] = run_in_turns(models, rounds);
  result.us = us[0];
  result.auto_us = us[1];
  result.spread = spread;
  for (std::size_t i = 0; i < result.effects.size(); ++i) result.effects[i].us = us[i + 2];
  return result;
}

std::string short_name(Part part) {
  const std::string text = to_string(part);
  return text.substr(0, text.find(" ("));
}

const PartEffect* effect_of(const CaseResult& result, Part part) {
  const auto found = std::ranges::find(result.effects, part, &PartEffect::part);
  return found == result.effects.end() ? nullptr : &*found;
}

/// Those that any of the scenes has.
std::vector<Part> parts_of(const std::vector<CaseResult>& results) {
  std::vector<Part> parts(kParts.begin(), kParts.end());
  std::erase_if(parts, [&](Part part) {
    return std::ranges::none_of(results, [&](const CaseResult& result) { return effect_of(result, part) != nullptr; });
  });
  return parts;
}

ordered_json part_columns(std::vector<std::string> columns, const std::vector<Part>& parts) {
  for (const Part part : parts) columns.push_back(short_name(part));
  return columns;
}

std::string runs_in_turns(int rounds) {
  return fmt::format(
      "Medians of {} runs; every variant of a scene ran once before any ran again. Errors are the same in each run, to "
      "the last bit.",
      rounds);
}

void add_costs(ordered_json& part, const std::vector<CaseResult>& results, int rounds) {
  std::vector<double> spread;
  for (const CaseResult& result : results) spread.insert(spread.end(), result.spread.begin(), result.spread.end());
  const double worst = spread.empty() ? 0.0 : std::ranges::max(spread), usual = percentiles(spread).p50;
  ordered_json& figure = add_figure(
      part, "table", "part_costs", "What each part of the model costs",
      fmt::format(
          "Microseconds of a tick that are saved where one part of the model is left out and all others stay; beside "
          "them what a tick takes with all parts. A tick is one step of contact and its share of the control tick "
          "(here nearly always one a step). Level of detail: the next coarser set of control points in the fingertips "
          "instead of the finest. Deformation of the fingertips: a rigid point of contact a finger instead of a pulp. "
          "A dash: the scene does not have the part. The runs of one and the same variant differed by {:.0f} % of a "
          "tick, as a median over all variants, and by {:.0f} % at most: less than that, of either sign, is noise.",
          100.0 * usual, 100.0 * worst),
      runs_in_turns(rounds));
  figure["columns"] = part_columns({"scene", "all parts, µs"}, parts_of(results));
  for (const CaseResult& result : results) {
    ordered_json row{result.name, std::round(10.0 * result.us) / 10.0};
    for (const Part what : parts_of(results)) {
      const PartEffect* const effect = effect_of(result, what);
      row.push_back(effect != nullptr ? ordered_json(fmt::format("{:.1f}", result.us - effect->us)) : "–");
    }
    figure["rows"].push_back(row);
  }
}

void add_errors(ordered_json& part, const std::vector<CaseResult>& results) {
  ordered_json& figure = add_figure(
      part, "table", "part_errors", "How much error each part removes",
      fmt::format("How far a scene goes astray where one part is left out, against the same scene with all parts: the "
                  "object's position and rotation, the fingers' forces (as a share), the torsions of their patches (as "
                  "a share of the most that friction lets them carry) and their margins, all rms. NEEDED marks what is "
                  "beyond the default tolerance, {}, rms or at the end; a word stands where the grasp ends in another "
                  "way than it does with all parts. A rigid fingertip's controller knows that it is rigid. The grip's "
                  "first 0.3 s do not count.",
                  in_words(Tolerance{})),
      "One run each: errors are the same in every run, to the last bit.");
  figure["columns"] = part_columns({"scene"}, parts_of(results));
  for (const CaseResult& result : results) {
    ordered_json row{result.name};
    for (const Part what : parts_of(results)) {
      const PartEffect* const effect = effect_of(result, what);
      const std::string cell = effect == nullptr ? "–"
                               : !effect->alike  ? std::string("NEEDED: ") + to_string(effect->verdict.outcome)
                                                 : (effect->within ? "" : "NEEDED: ") + in_words(effect->error);
      row.push_back(cell);
    }
    figure["rows"].push_back(row);
  }
}

void add_needs(ordered_json& part, const std::vector<CaseResult>& results) {
  ordered_json& figure = add_figure(
      part, "table", "part_needs", "Which parts are needed at all",
      "For each part of the model: in how many of the scenes above it is modelled, in which of them it cannot be left "
      "out within the default tolerance, and the largest error that leaving it out makes in the others. What is needed "
      "in none of them is kept all the same: that the object gives way, that bodies remember, and that fingertips "
      "stiffen are properties of bodies, which a scene has because it names them, and which cost one that does not "
      "name them nothing. Muscles are part of the published model. Without them the motion is the same, for as long as "
      "none reaches its limit they give the very torques that are asked for: they tell what a hand can do.",
      "One run each: errors are the same in every run, to the last bit.");
  figure["columns"] = {"part", "scenes with it", "needed in", "largest error where it is not needed"};
  for (const Part what : parts_of(results)) {
    int with = 0;
    std::string needed;
    PathDeviation largest;
    bool needed_in_all = true;
    for (const CaseResult& result : results) {
      const PartEffect* const effect = effect_of(result, what);
      if (effect == nullptr) continue;
      ++with;
      if (!effect->within) {
        needed += (needed.empty() ? "" : ", ") + result.name;
        continue;
      }
      needed_in_all = false;
      largest.position_rms_m = std::max(largest.position_rms_m, effect->error.position_rms_m);
      largest.rotation_rms_rad = std::max(largest.rotation_rms_rad, effect->error.rotation_rms_rad);
      largest.force = std::max(largest.force, effect->error.force);
      largest.moment = std::max(largest.moment, effect->error.moment);
      largest.margin = std::max(largest.margin, effect->error.margin);
    }
    figure["rows"].push_back(
        {to_string(what), with, needed.empty() ? "none" : needed, needed_in_all ? "–" : in_words(largest)});
  }
}

void add_auto(ordered_json& part, const std::vector<CaseResult>& results, int rounds) {
  ordered_json& figure = add_figure(
      part, "table", "model_auto", "What `model: auto` leaves out",
      fmt::format("With `model: auto` a scene is run a few times when it is loaded, and parts are left out one after "
                  "the other as long as all that is left out together stays within the scene's tolerance, here the "
                  "default: {}. Only errors decide, so that the same scene always keeps the same parts. 'Detail to 4': "
                  "control points of level 4, where each stands for about 16 of the finest.",
                  in_words(Tolerance{})),
      runs_in_turns(rounds));
  figure["columns"] = {"scene", "left out", "all parts, µs a tick", "auto, µs a tick", "times as fast", "off by"};
  for (const CaseResult& result : results) {
    std::string left_out;
    const PartEffect* last = nullptr;
    for (const PartEffect& effect : result.auto_parts) {
      if (!effect.within) continue;
      last = &effect;
      left_out += (left_out.empty() ? "" : ", ") +
                  (effect.part == Part::kDetail ? fmt::format("detail to {}", effect.level) : short_name(effect.part));
    }
    if (!result.failure.empty()) left_out = "not tried, for the scene fails: " + result.failure;
    figure["rows"].push_back({result.name, left_out.empty() ? "nothing" : left_out, fmt::format("{:.1f}", result.us),
                              fmt::format("{:.1f}", result.auto_us), fmt::format("{:.1f}", result.us / result.auto_us),
                              last != nullptr ? in_words(last->error) : "–"});
  }
}

// --- levels of detail, against fingertips finer than any scene's -----------------------------------------------------

struct Variant {
  std::string method, setting;
  Scene scene;
  bool is_default = false;
};

/// The scene's fingertips, and coarser and simpler ones.
std::vector<Variant> variants(const Scene& scene) {
  std::vector<Variant> all{{"levels of detail", "leaves, the default", scene, true}};
  Scene coarser = scene;
  for (int level = 1; level <= 5; ++level) {
    coarser = leave_out(coarser, Part::kDetail);
    all.push_back({"levels of detail", fmt::format("level {}", level), coarser});
  }
  for (const Part what : {Part::kFingertips, Part::kMuscles, Part::kFingertipMemory}) {
    if (has(scene, what)) all.push_back({"without " + short_name(what), "", leave_out(scene, what)});
  }
  const Model model = build_model(scene);
  all.push_back({"model: auto", "", needed_parts(model, run_path(model)).scene});
  return all;
}

ordered_json detail_case(const Case& item, int rounds) {
  const Scene scene = item.load();
  std::vector<Variant> all = variants(scene);
  Model finest =
      build_model(item.load({"fingertips.leaves=1280", "fingertips.points=9600", "contact.max_per_finger=160"}));
  const PathRun reference = run_path(finest);
  const auto first = static_cast<std::size_t>(std::lround(kMeasuredFrom_s / scene.step_s));
  std::vector<Model> models;
  for (const Variant& variant : all) models.push_back(build_model(variant.scene, finest));
  const std::vector<double> us = run_in_turns(models, rounds).median_us;
  ordered_json points = ordered_json::array();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const PathRun run = run_path(models[i]);
    if (!run.ended) continue;
    WorkPoint point{all[i].method, all[i].setting, 100.0 * deviation(run.path, reference.path, first).force, us[i]};
    point.is_default = all[i].is_default;
    points.push_back(point);
  }
  return {{"name", fmt::format("{} (the reference takes {:.0f} µs)", item.name, reference.us)}, {"points", points}};
}

void add_detail(ordered_json& part, bool quick, int rounds) {
  ordered_json& figure = add_figure(
      part, "work_precision", "detail_precision", "Less of a model: how fast, and how far off",
      "What a tick takes (contact step and its share of control) against how far the fingers' forces on the object are "
      "off, rms over the scene, measured against fingertips four times as fine as the scene's, with all their contacts "
      "(1280 control points instead of 320, up to 160 contacts a finger instead of 20). Lower and further left is "
      "better. The line joins levels of detail, each with about half as many control points as the last; single points "
      "leave one part out of the scene's own model, or are what `model: auto` makes of it within the tolerance of "
      "the scene's own path and forces. A point that is missing lost the object.",
      runs_in_turns(rounds));
  figure["error"] = "error of the forces against the finest model, rms [%]";
  figure["time"] = "time of a tick [µs]";
  figure["cases"] = ordered_json::array();
  for (const Case& item : quick ? std::vector<Case>{kBox} : std::vector<Case>{kBox, kCapsule, kMug, kStick, kSlide}) {
    figure["cases"].push_back(detail_case(item, rounds));
  }
}

// --- the part of two loops that has no key --------------------------------------------------------------------------

/// Two loops on a virtual clock, to their end or the object's loss.
struct SplitRun {
  GraspPath path;
  double contact_us = 0.0;  ///< Median contact tick.
};

SplitRun run_split(const Model& model, bool curvature) {
  LockstepSettings settings;
  settings.channel = [&](double, Frame& frame) {
    for (FrameContact& contact : frame.contacts) {
      if (!curvature) contact.curvature_per_m = contact.ring_curvature_per_m = 0.0;
    }
    return true;
  };
  GraspRun loops(model, settings);
  SplitRun run;
  std::vector<double> us;
  for (const auto end = std::lround(model.scene.duration_s / model.scene.step_s); loops.state.tick < end;) {
    const TickReport tick = loops.tick();
    us.push_back(1e6 * (tick.assemble_s + tick.solve_s + tick.deform_s));
    run.path.see_tick(Tick{loops.state, tick, loops.report, loops.controller.f_muscle});
  }
  run.contact_us = percentiles(std::move(us)).p50;
  return run;
}

void add_curvature_rows(ordered_json& rows, const Case& item, double period_ms, int rounds) {
  const auto every = [&](double period, double delay) {
    return item.load({"time.step=0.25 ms", fmt::format("time.control_period={:g} ms", period),
                      fmt::format("time.control_delay={:g} ms", delay)});
  };
  const Model model = build_model(every(period_ms, period_ms));
  // Frames of every step that are never late. Without control the drive is the same; with it, so is the controller's
  // part of the difference in both rows of a scene.
  const GraspPath reference = run_split(build_model(every(0.25, 0.0), model), true).path;
  const auto first = static_cast<std::size_t>(std::lround(kMeasuredFrom_s / model.scene.step_s));
  std::array<std::vector<double>, 2> us;
  std::array<SplitRun, 2> runs;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t without : {0U, 1U}) {
      runs[without] = run_split(model, without == 0);
      us[without].push_back(runs[without].contact_us);
    }
  }
  for (std::size_t without : {0U, 1U}) {
    const PathDeviation error = deviation(runs[without].path, reference, first);
    rows.push_back(
        {item.name, fmt::format("{:g} ms", period_ms), without == 0 ? "spheres" : "planes",
         fmt::format("{:.1f}", percentiles(us[without]).p50), fmt::format("{:.3g}", 1e6 * error.position_rms_m),
         fmt::format("{:.3g}", kRadian_deg * error.rotation_rms_rad), fmt::format("{:.3g}", 100.0 * error.force)});
  }
}

void add_curvature(ordered_json& part, bool quick, int rounds) {
  ordered_json& figure = add_figure(
      part, "table", "curvature", "Curvature, which only late frames need",
      "Contacts are found by the control loop, every 5 or 20 ms and as much late, while the contact loop goes on at 4 "
      "kHz. Between two frames it takes the object's surface at each contact for a sphere of the surface's curvature; "
      "without, for a plane. On flat faces the two are the same. Errors are against the same scene whose frames come "
      "at every step (4 kHz), and are never late: of scenes without control (ball, box on a spring) that is all there "
      "is, in grasps most of it is the controller's own delay, the same in both rows. What the fit of curvatures costs "
      "is a part of contact finding and not in the column of the contact tick.",
      runs_in_turns(rounds));
  figure["columns"] = {
      "scene",        "frames", "surface between them", "contact tick, µs", "path off, µm rms", "turned off, ° rms",
      "forces off, %"};
  figure["rows"] = ordered_json::array();
  const std::vector<Case> items =
      quick ? std::vector<Case>{kSlide} : std::vector<Case>{kSlide, kStick, kBox, kCapsule, kMug};
  for (const Case& item : items) {
    add_curvature_rows(figure["rows"], item, 5.0, rounds);
    // With frames every 20 ms the other grasps are lost.
    if (&item - items.data() < 3) add_curvature_rows(figure["rows"], item, 20.0, rounds);
  }
}

void add_all(ordered_json& part, bool quick) {
  constexpr int kRounds = 3;
  std::vector<CaseResult> results;
  for (const Case& item : cases(quick)) results.push_back(measure(item, kRounds));
  add_costs(part, results, kRounds);
  add_errors(part, results);
  add_needs(part, results);
  add_auto(part, results, kRounds);
  add_detail(part, quick, quick ? 1 : kRounds);
  add_curvature(part, quick, quick ? 1 : kRounds);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(
      argc, argv, "model", "No more than a scene needs",
      "What a scene does not name is not modelled. Of what it names, each part was left out by itself: what it costs, "
      "and how far the object's path and the fingers' forces go astray without it. `thenar check SCENE` prints the "
      "same for a scene of your own, and `model: auto` leaves out what its tolerance does not need.",
      {add_all});
}
