// SPDX-License-Identifier: Apache-2.0
// Grasps that are found: 200 random objects, what becomes of each grasp in the engine, the time of finding, how the
// friction that a grasp is said to need compares with the least one that it holds with, and where there are none.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "bench/cases/random_objects.h"
#include "bench/report/figure.h"
#include "bench/report/outcome_map.h"
#include "engine/models/scene_grasp.h"
#include "engine/results/scene_run.h"
#include "engine/scenes/scene_file.h"

namespace thenar {
namespace {

using nlohmann::ordered_json;

constexpr std::uint32_t kFirstSeed = 1;
constexpr int kReferenceEffort = 12;

/// The box grasp's hand and controller at a friction of 0.6.
Scene base_scene() {
  return load_scene(std::string(THENAR_CONFIGS) + "/box_grasp.yaml",
                    {"contact.friction=0.6", "control.grasp={friction: 0.42, internal_force: 2 N}"});
}

struct Trial {
  RandomObject object;
  FinderReport report = {};
  double finding_s = 0.0;
  HoldTrial hold = {};
  bool reference = false;  ///< The slow search found a grasp where the usual one did not.
};

Trial trial_of(const Scene& base, std::uint32_t seed, bool with_reference) {
  Trial trial{.object = random_object(seed)};
  const Scene scene = scene_with(base, trial.object);
  const ImplicitSurface surface = surface_of(scene, trial.object);
  const std::clock_t began = std::clock();  // of this thread's work: nothing else runs
  trial.report = find_tried_grasps(scene, surface);
  trial.finding_s = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  if (!trial.report.grasps.empty()) {
    trial.hold = carry_and_push(model_with(scene, surface, trial.report.grasps.front()),
                                trial.report.grasps.front().travel_W, seed);
  } else if (with_reference) {
    trial.reference =
        !find_tried_grasps(scene, surface, {.seed = 1000 + seed, .effort = kReferenceEffort}).grasps.empty();
  }
  return trial;
}

bool ends(const Trial& trial, Outcome outcome) {
  return !trial.report.grasps.empty() && trial.hold.verdict.outcome == outcome;
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void add_kinds(const std::vector<Trial>& trials, ordered_json& part) {
  struct Count {
    int objects = 0, found = 0, held = 0, over = 0, missed = 0;
    std::vector<double> s;
  };
  std::map<std::string, Count> kinds;
  for (const Trial& trial : trials) {
    for (const std::string& kind : {trial.object.name.substr(0, trial.object.name.find(' ')), std::string("zz all")}) {
      Count& count = kinds[kind];
      ++count.objects;
      count.found += trial.report.grasps.empty() ? 0 : 1;
      count.held += ends(trial, Outcome::kHeld) ? 1 : 0;
      count.over += ends(trial, Outcome::kOverLimits) ? 1 : 0;
      count.missed += trial.reference ? 1 : 0;
      count.s.push_back(trial.finding_s);
    }
  }
  ordered_json& figure = add_figure(
      part, "table", "found_grasps", "Grasps of random objects",
      fmt::format("Objects of 8 to 120 mm, 30 to 150 g, in any frame, seeds {} to {}. Held: carried by 20 mm in the "
                  "direction that its joints allow most, and then pushed by 0.5 N at a friction of 0.6, without a "
                  "finger that slips, a joint or "
                  "muscle beyond its limits. Over limits: held, but a muscle was asked for more than it has. Missed: "
                  "refused, while a search {} times as long, from another "
                  "seed, finds a grasp.",
                  kFirstSeed, kFirstSeed + trials.size() - 1, kReferenceEffort),
      "one search of each object on one core, by the processor's time; medians over objects");
  figure["columns"] = {"objects of a kind", "objects", "found",    "held",
                       "over limits",       "missed",  "median s", "longest s"};
  figure["rows"] = ordered_json::array();
  for (const auto& [kind, count] : kinds) {
    figure["rows"].push_back({kind == "zz all" ? "all" : kind, count.objects, count.found, count.held, count.over,
                              count.missed, std::round(1e3 * quantile(count.s, 0.5)) / 1e3,
                              std::round(1e3 * quantile(count.s, 1.0)) / 1e3});
  }
}

void add_reasons(const std::vector<Trial>& trials, ordered_json& part) {
  ordered_json& figure =
      add_figure(part, "table", "found_grasps_not_held", "Objects without a grasp, and grasps that did not hold",
                 "Each with the reason that a user gets.", "as above");
  figure["columns"] = {"seed", "object", "what became of it"};
  figure["rows"] = ordered_json::array();
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const Trial& trial = trials[i];
    if (ends(trial, Outcome::kHeld)) continue;
    const std::string what = !trial.report.grasps.empty() ? in_words(trial.hold.verdict)
                             : trial.report.refusal       ? "refused: " + in_words(*trial.report.refusal)
                                                          : "refused";
    figure["rows"].push_back({kFirstSeed + i, trial.object.name, what + (trial.reference ? " (missed)" : "")});
  }
}

void random_objects(ordered_json& part, bool quick) {
  const Scene base = base_scene();
  std::vector<Trial> trials;
  for (std::uint32_t seed = kFirstSeed; seed < kFirstSeed + (quick ? 21U : 200U); ++seed) {
    trials.push_back(trial_of(base, seed, !quick || seed % 3 == 0));
  }
  add_kinds(trials, part);
  add_reasons(trials, part);
}

/// Predicted and simulated least friction.
void margins(ordered_json& part, bool quick) {
  const Scene base = base_scene();
  ordered_json& figure = add_figure(
      part, "table", "found_margin", "Friction that a found grasp needs, predicted and simulated",
      "Predicted: what the grasp's trial says, by the forces and torsions of its patches at rest at a friction of 0.6. "
      "Simulated: the least friction of the contacts, bisected to 1 %, with which the object is held for a second and "
      "no "
      "patch slides as a whole by more than 0.1 mm, the controller as before.",
      "deterministic: one run of each friction");
  figure["columns"] = {"object", "predicted", "simulated", "simulated / predicted"};
  figure["rows"] = ordered_json::array();
  int compared = 0;
  for (std::uint32_t seed = kFirstSeed; compared < (quick ? 3 : 10) && seed < kFirstSeed + 60; ++seed) {
    const RandomObject object = random_object(seed);
    const Scene scene = scene_with(base, object);
    const ImplicitSurface surface = surface_of(scene, object);
    const FinderReport report = find_tried_grasps(scene, surface);
    if (report.grasps.empty() || report.grasps.front().needed_friction < 0.02) continue;
    const Model model = model_with(scene, surface, report.grasps.front());
    const double predicted = report.grasps.front().needed_friction;
    const double simulated = least_friction(model, 0.3 * predicted, 3.0 * predicted);
    figure["rows"].push_back({object.name, predicted, simulated, simulated / predicted});
    ++compared;
  }
}

/// Where the finder has grasps, and whether they hold: the scene asks for any, and carries the object by 10 mm.
void maps(ordered_json& part, bool quick) {
  const std::vector<std::string> any = {"grasp=auto", "control.grasp={friction: 0.42, internal_force: 2 N}",
                                        "contact.friction=0.6"};
  const std::string text =
      " Each cell asks for any grasp (`grasp: auto`), which is then carried by 10 mm. Refused: the finder gives no "
      "grasp, "
      "and the reason.";
  const auto with = [&](const std::string& change) {
    std::vector<std::string> all = any;
    all.push_back(change);
    return all;
  };
  const MapPanel ours{"found", true, [](const Model& model) {
                        State state(model);
                        return run_scene(model, state);
                      }};
  const int count = quick ? 4 : 9;
  add_map(part,
          {.id = "found_map_mass",
           .title = "Grasps that are found: size and mass of a ball",
           .caption = "Balls that are squeezed by 2 N at a friction of 0.6." + text,
           .x = {"object.shape.sphere", "mm", 3.0, 60.0, "diameter, mm", [](double r) { return 2.0 * r; }},
           .y = {"object.mass", "g", 10.0, 1000.0, "mass, g"},
           .overrides = with("object.shape={sphere: 15 mm}"),
           .panels = {ours},
           .scene = "found_carry"},
          count);
  add_map(part,
          {.id = "found_map_friction",
           .title = "Grasps that are found: thickness of a disc and friction",
           .caption = "Discs of 50 mm and 60 g; the controller's cones have a friction of 0.42." + text,
           .x = {"object.shape.cylinder.length", "mm", 1.0, 80.0, "thickness, mm"},
           .y = {"contact.friction", "", 0.1, 1.5, "friction"},
           .overrides = with("object.shape={cylinder: {radius: 25 mm, length: 20 mm}}"),
           .panels = {ours},
           .scene = "found_carry"},
          count);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  return thenar::run_part(argc, argv, "grasp_finding", "Grasps that are found",
                          "How a hand can hold an object is searched, and each grasp is then run in the engine.",
                          {thenar::random_objects, thenar::margins, thenar::maps});
}
