// Step sizes, rates and settings for the whole grasp: the error of the object's path and of the fingers' forces, against
// the finest run, over what a simulated millisecond costs. All on the virtual clock and one thread: errors are the same
// in every run.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <numbers>

#include "bench/report/figure.h"
#include "bench/split_runs.h"
#include "engine/percentiles.h"

namespace thenar {
namespace {

using nlohmann::ordered_json;

constexpr double kReference_s = 50e-6;
constexpr double kLost_m = 5e-3;  // An object so far off is lost, and its forces say nothing.

/// Where the runs of a scene begin, where they are judged from, and their ends.
struct Scenario {
  const char* name;
  double start_s, from_s, until_s, quick_until_s;

  [[nodiscard]] double end_s(bool quick) const { return quick ? quick_until_s : until_s; }
};
constexpr Scenario kStick{"stick", 0.16, 0.2, 1.0, 0.6}, kSlide{"slide", 0.16, 0.2, 1.2, 0.6};
constexpr Scenario kBoxGrasp{"box_grasp", 0.0, 0.3, 2.5, 1.0}, kBoxTurn{"box_turn", 0.0, 0.3, 2.5, 1.0};
constexpr Scenario kCapsule{"capsule", 0.0, 0.3, 2.5, 1.0};
constexpr Scenario kAll[]{kStick, kSlide, kBoxGrasp, kBoxTurn, kCapsule};

Scene scene_of(const Scenario& scenario, const std::vector<std::string>& changes = {}) {
  return load_scene(std::filesystem::path(THENAR_CONFIGS) / (std::string(scenario.name) + ".yaml"), changes);
}

std::string rate(double step_s) {
  return step_s <= 1e-3 ? fmt::format("{:g} kHz", 1e-3 / step_s) : fmt::format("{:g} Hz", 1.0 / step_s);
}

/// Wall time per simulated time: 1000 is as fast as life.
double us_per_ms(const Path& path) { return path.wall_s / (static_cast<double>(path.X_WO.size()) * path.step_s) * 1e3; }

/// A way to run a scene, its error, and what it cost in each run.
struct Way {
  std::string method, setting;
  bool is_default;
  std::function<Path()> run;
  bool is_scene = false;  ///< Nothing is changed: the same runs as all others of which that is true.
  PathError error = {};
  std::vector<double> us = {};
};

/// Runs all ways in turns.
void measure(std::vector<Way>& ways, const Path& reference, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    for (Way& way : ways) {
      const Path path = way.run();
      way.us.push_back(us_per_ms(path));
      if (round == 0) way.error = path_error(path, reference);
    }
  }
  std::vector<double> of_scene;
  for (const Way& way : ways) {
    if (way.is_scene) of_scene.insert(of_scene.end(), way.us.begin(), way.us.end());
  }
  for (Way& way : ways) {
    if (way.is_scene) way.us = of_scene;
  }
}

/// The two figures of one choice: errors of path and of force.
struct Charts {
  ordered_json path, force;

  Charts(const std::string& id, const std::string& title, const std::string& choice, const std::string& caption,
         const std::string& runs)
      : path(chart(id + "_path", title + ": the object's path", choice,
                   "Error: of the object's position, rms over the run. " + caption, runs, "rms position error [um]")),
        force(chart(id + "_force", title + ": the fingers' forces", choice,
                    "Error: of the force of a loaded finger on the object, rms over fingers and the run. " + caption,
                    runs, "rms force error [mN]")) {}

  void add_case(const std::string& name, const std::vector<Way>& ways) {
    ordered_json path_points = ordered_json::array(), force_points = ordered_json::array();
    for (const Way& way : ways) {
      const bool lost = way.error.position_m > kLost_m;
      WorkPoint point{.method = way.method,
                      .setting = way.setting + (lost ? ", lost" : ""),
                      .error = 1e6 * way.error.position_m,
                      .us = percentiles(way.us).p50,
                      .is_default = way.is_default};
      path_points.push_back(point);
      point.error = 1e3 * way.error.force_N;
      if (!lost) force_points.push_back(point);
    }
    path["cases"].push_back({{"name", name}, {"points", path_points}});
    force["cases"].push_back({{"name", name}, {"points", force_points}});
  }

  void add_to(ordered_json& part) const {
    part["figures"].push_back(path);
    part["figures"].push_back(force);
  }

 private:
  static ordered_json chart(const std::string& id, const std::string& title, const std::string& choice,
                            const std::string& caption, const std::string& runs, const std::string& error) {
    ordered_json holder{{"figures", ordered_json::array()}};
    ordered_json figure = add_figure(holder, "work_precision", id, title, caption, runs);
    figure["choice"] = choice;
    figure["error"] = error;
    figure["time"] = "cost of a simulated millisecond [us]";
    return figure;
  }
};

// --- Steps and rates ------------------------------------------------------------------------------------------------

std::vector<Way> one_loop_ways(const Scene& scene, const Course& course, bool quick) {
  std::vector<Way> ways;
  for (const double step_s : {20e-3, 10e-3, 5e-3, 2e-3, 1e-3, 0.5e-3, 0.25e-3, 0.1e-3}) {
    if (quick && step_s < 0.2e-3) continue;
    const Timing timing{step_s, std::max(step_s, scene.control_period_s)};
    ways.push_back({"one loop", fmt::format("{:g} ms", 1e3 * step_s), step_s == scene.step_s,
                    [&course, timing] { return course.in_one_loop(timing); }});
  }
  return ways;
}

std::vector<Way> two_loop_ways(const Course& course, bool quick) {
  constexpr double kContact_s = 0.25e-3, kControl_s = 5e-3;  // Of `thenar profile`.
  std::vector<Way> ways;
  for (const double period_s : {1e-3, 5e-3, 20e-3}) {
    for (const double step_s : {1e-3, 0.5e-3, 0.25e-3, 0.1e-3}) {
      if (quick && (step_s == 0.5e-3 || step_s < 0.2e-3)) continue;
      const Timing timing{step_s, period_s, period_s};
      ways.push_back({"control at " + rate(period_s), "contact at " + rate(step_s),
                      step_s == kContact_s && period_s == kControl_s,
                      [&course, timing] { return course.split(timing); }});
    }
  }
  return ways;
}

void steps_and_rates(ordered_json& part, bool quick) {
  const int rounds = quick ? 1 : 3;
  const std::string against = fmt::format(
      " Against one loop with steps of {:g} us and control as often as the scene has it. Down and left is better. "
      "Stick: three fingertips press on a box that a spring carries and turns, nobody controls. Slide: a ball is "
      "dragged along a fingertip. Box grasp, box turn, capsule: held and moved by the controlled hand. Where contacts "
      "stick, they remember the order in which they touched, which another step takes in another order: stick and "
      "slide go on from one state; the grasps begin anew, and differ by that, too.",
      1e6 * kReference_s);
  const std::string runs =
      rounds == 1 ? "a single run of each" : fmt::format("medians of {} runs of each, in turns", rounds);
  Charts one("one_loop", "Steps of the one loop", "time.step",
             "One loop does everything at every step; control as often as the scene has it, or every step if that is "
             "longer. The scene's own step, 1 ms, is the default." +
                 against,
             runs);
  Charts two(
      "two_loops", "Rates of the two loops", "rates",
      "Contact and control with clocks of their own; a frame comes into use a control period after its snapshot. "
      "Control late by 5 ms cannot be made up for by a faster contact loop, and its part of the error is that of a "
      "slower controller, not of the contact loop. 4 kHz and 200 Hz, what real-time runs have, are the default: the "
      "contact rate is a haptic device's, which takes 1 kHz at least." +
          against,
      runs);
  for (const Scenario& scenario : kAll) {
    const Scene scene = scene_of(scenario);
    const double period_s = scene.control ? scene.control_period_s : kReference_s;
    const Course course(scene, {kReference_s, period_s}, scenario.start_s, scenario.from_s, scenario.end_s(quick));
    const Path reference = course.in_one_loop({kReference_s, period_s});
    std::vector<Way> ways = one_loop_ways(scene, course, quick);
    const auto singles = ways.size();
    for (Way& way : two_loop_ways(course, quick)) ways.push_back(std::move(way));
    measure(ways, reference, rounds);
    const auto middle = ways.begin() + static_cast<std::ptrdiff_t>(singles);
    one.add_case(scene.name, {ways.begin(), middle});
    two.add_case(scene.name, {middle, ways.end()});
  }
  one.add_to(part);
  two.add_to(part);
}

// --- What the split adds --------------------------------------------------------------------------------------------

void hand_over(ordered_json& part, bool quick) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  ordered_json& figure = add_figure(
      part, "table", "hand_over", "What the split alone adds, with and without the offset at hand-overs",
      fmt::format(
          "The two loops against one loop with steps of {:g} us that has the same control period and delay: what is "
          "left is the error of the contact rate, of old frames, and of handing over from one to the next. Offset: "
          "gaps agree at a hand-over and move on to the new frame's in a control period. Steps of the force: the "
          "largest change of a finger's force from tick to tick, where a new frame comes into use and elsewhere. "
          "Injected: work that contact did on the bodies, over what it took from them; 0 is passive. The offset is the "
          "default; smaller is better everywhere.",
          1e6 * kReference_s),
      "deterministic");
  figure["columns"] = {
      "scene",           "contact",    "frames every [ms]",      "offset",         "position [um]",
      "rotation [mdeg]", "force [mN]", "step at new frame [mN]", "step else [mN]", "injected/dissipated"};
  for (const Scenario& scenario : {kStick, kSlide, kBoxGrasp}) {
    const Scene scene = scene_of(scenario);
    for (const double period_s : {5e-3, 20e-3}) {
      const Timing finest =
          scene.control ? Timing{kReference_s, period_s, period_s} : Timing{kReference_s, kReference_s};
      const Course course(scene, finest, scenario.start_s, scenario.from_s, scenario.end_s(quick));
      const Path reference = course.in_one_loop(finest);
      for (const double step_s : {1e-3, 0.25e-3}) {
        for (const bool offset : {true, false}) {
          if (quick && step_s == 1e-3) continue;
          const Path path = course.split({step_s, period_s, period_s}, offset);
          const PathError error = path_error(path, reference);
          figure["rows"].push_back({scene.name, rate(step_s), 1e3 * period_s, offset ? "on" : "off",
                                    1e6 * error.position_m, 1e3 * error.rotation_rad / kDegree, 1e3 * error.force_N,
                                    1e3 * path.handover_step_N, 1e3 * path.ordinary_step_N,
                                    path.injected_J / path.dissipated_J});
        }
      }
    }
  }
}

// --- Settings -------------------------------------------------------------------------------------------------------

Path run_scene(const Model& model, const Scenario& scenario, bool quick) {
  State state(model);
  return run_in_one_loop(model, state, scenario.from_s, scenario.end_s(quick));
}

/// So many control points, and contacts in proportion.
std::vector<std::string> with_leaves(int leaves) {
  return {fmt::format("fingertips.leaves={}", leaves), fmt::format("fingertips.points={}", leaves * 15 / 2),
          fmt::format("contact.max_per_finger={}", leaves / 16)};
}

/// One setting at a time, the others as the scene has them.
std::vector<Way> setting_ways(const Model& known, const Scenario& scenario, bool quick) {
  std::vector<Way> ways;
  const auto add = [&](const std::string& method, const std::string& setting, const std::vector<std::string>& changes,
                       bool is_scene) {
    auto model = std::make_shared<const Model>(scene_of(scenario, changes), known);
    ways.push_back({method, setting, false,
                    [model = std::move(model), &scenario, quick] { return run_scene(*model, scenario, quick); },
                    is_scene});
  };
  for (const int digits : {2, 3, 4, 5, 6, 7, 9}) {
    add("contact.tolerance", fmt::format("1e-{}", digits),
        {fmt::format("contact.tolerance=1e-{}", digits), "contact.max_sweeps=1000"}, digits == 6);
  }
  for (const int most : {3, 5, 10, 20, 40}) {
    add("contact.max_per_finger", fmt::format("{} contacts a finger", most),
        {fmt::format("contact.max_per_finger={}", most)}, most == 20);
  }
  for (const int leaves : {80, 160, 320, 640}) {
    add("fingertips.leaves", fmt::format("{} leaves", leaves), with_leaves(leaves), leaves == 320);
  }
  // All three lines pass through the scene itself; it is the default once.
  for (Way& way : ways) way.is_default = way.is_scene && way.method == "contact.tolerance";
  return ways;
}

void settings(ordered_json& part, bool quick) {
  constexpr int kFinest = 1280;
  const int rounds = quick ? 1 : 3;
  Charts charts(
      "settings", "Settings of contact and fingertips", "contact.tolerance, contact.max_per_finger, fingertips.leaves",
      fmt::format(
          "One loop at the scene's own step; one setting at a time differs from the scene's, which is the default "
          "(tolerance 1e-6, 20 contacts a finger, 320 leaves; with other numbers of leaves as many contacts in "
          "proportion). Against {} leaves, up to {} contacts a finger, solved to 1e-10: an error that a tighter "
          "tolerance leaves is that of the number of control points. Down and left is better: where a line is flat, "
          "what is spent is wasted; where it is steep, it pays.",
          kFinest, kFinest / 16),
      rounds == 1 ? "a single run of each" : fmt::format("medians of {} runs of each, in turns", rounds));
  for (const Scenario& scenario : {kBoxGrasp, kCapsule, kSlide}) {
    const Model known(scene_of(scenario));
    std::vector<std::string> changes = with_leaves(kFinest);
    changes.insert(changes.end(), {"contact.tolerance=1e-10", "contact.max_sweeps=2000"});
    const Path reference = run_scene(Model(scene_of(scenario, changes), known), scenario, quick);
    std::vector<Way> ways = setting_ways(known, scenario, quick);
    measure(ways, reference, rounds);
    charts.add_case(known.scene.name, ways);
  }
  charts.add_to(part);
}

void run(const PartArguments& arguments) {
  ordered_json part =
      make_part("rates", "Steps, rates and settings for the whole grasp",
                "What a coarser or finer run of the same scene costs, and how far it takes the object and the forces "
                "from the finest one.",
                arguments);
  steps_and_rates(part, arguments.quick);
  hand_over(part, arguments.quick);
  settings(part, arguments.quick);
  write_part(part, arguments);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) { thenar::run(thenar::part_arguments(argc, argv)); }
