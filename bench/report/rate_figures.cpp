// SPDX-License-Identifier: Apache-2.0
// Step sizes, rates and settings for the whole grasp: the error of the object's path and of the fingers' forces,
// against the finest run, over what a simulated millisecond costs. All on the virtual clock and one thread: errors are
// the same in every run.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>

#include "bench/cases/split_runs.h"
#include "bench/report/figure.h"
#include "engine/loops/percentiles.h"
#include "engine/models/build_model.h"
#include "engine/scenes/scene_file.h"

namespace thenar {
namespace {

using nlohmann::ordered_json;

constexpr double kReference_s = 50e-6;
constexpr double kContact_s = 0.25e-3, kControl_s = 1e-3;  // Of real-time runs.
constexpr double kLost_m = 5e-3;                           // An object so far off is lost, and has no error.

/// Where the runs of a scene begin, where they are judged from, and their ends.
struct Scenario {
  const char* name;
  double start_s, from_s, until_s, quick_until_s;

  [[nodiscard]] double end_s(bool quick) const { return quick ? quick_until_s : until_s; }
};
constexpr Scenario kStick{"stick", 0.16, 0.2, 1.0, 0.6}, kSlide{"slide", 0.16, 0.2, 1.2, 0.6};
constexpr Scenario kBoxGrasp{"box_grasp", 0.0, 0.3, 2.5, 1.0}, kBoxTurn{"box_turn", 0.0, 0.3, 2.5, 1.0};
constexpr Scenario kCapsule{"capsule", 0.0, 0.3, 2.5, 1.0}, kMug{"mug", 0.0, 0.3, 2.5, 1.0};
constexpr Scenario kAll[]{kStick, kSlide, kBoxGrasp, kBoxTurn, kCapsule};
constexpr Scenario kControlled[]{kBoxGrasp, kBoxTurn, kCapsule, kMug};
constexpr Scenario kTolerances[]{kBoxGrasp, kCapsule, kSlide, kBoxTurn}, kDetailed[]{kBoxGrasp, kCapsule, kSlide};

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
  PathError error = {};
  std::vector<double> us = {};
};

/// Runs all ways in turns; `judge` tells a path's error.
template <typename Judge>
void measure(std::vector<Way>& ways, int rounds, Judge&& judge) {
  for (int round = 0; round < rounds; ++round) {
    for (Way& way : ways) {
      const Path path = way.run();
      way.us.push_back(us_per_ms(path));
      if (round == 0) way.error = judge(path);
    }
  }
}

void measure_against(const Path& reference, std::vector<Way>& ways, int rounds) {
  measure(ways, rounds, [&](const Path& path) { return path_error(path, reference); });
}

std::string runs_of(int rounds) {
  return rounds == 1 ? "a single run of each" : fmt::format("medians of {} runs of each, in turns", rounds);
}

ordered_json chart(const std::string& id, const std::string& title, const std::string& choice,
                   const std::string& caption, const std::string& runs, const std::string& error) {
  ordered_json holder{{"figures", ordered_json::array()}};
  ordered_json figure = add_figure(holder, "work_precision", id, title, caption, runs);
  if (!choice.empty()) figure["choice"] = choice;
  figure["error"] = error;
  figure["time"] = "cost of a simulated millisecond [µs]";
  return figure;
}

/// A case of a chart; `error` takes what is charted out of a way's.
template <typename Error>
void add_case(ordered_json& figure, const std::string& name, const std::vector<Way>& ways, Error&& error) {
  ordered_json points = ordered_json::array();
  for (const Way& way : ways) {
    const bool lost = way.error.position_m > kLost_m;
    points.push_back(WorkPoint{.method = way.method,
                               .setting = way.setting + (lost ? ", lost" : ""),
                               .error = lost ? std::numeric_limits<double>::quiet_NaN() : error(way.error),
                               .us = percentiles(way.us).p50,
                               .is_default = way.is_default});
  }
  figure["cases"].push_back({{"name", name}, {"points", points}});
}

/// The two figures of one choice: errors of path and of force.
struct Charts {
  ordered_json path, force;

  Charts(const std::string& id, const std::string& title, const std::string& choice, const std::string& caption,
         const std::string& runs)
      : path(chart(id + "_path", title + ": the object's path", choice,
                   caption + " Error: of the object's position, rms over the run.", runs, "rms position error [µm]")),
        force(chart(id + "_force", title + ": the fingers' forces", choice,
                    caption + " Error: of the force of a loaded finger on the object, rms over fingers and the run.",
                    runs, "rms force error [mN]")) {}

  void add(const std::string& name, const std::vector<Way>& ways) {
    add_case(path, name, ways, [](const PathError& error) { return 1e6 * error.position_m; });
    add_case(force, name, ways, [](const PathError& error) { return 1e3 * error.force_N; });
  }

  void add_to(ordered_json& part) const {
    part["figures"].push_back(path);
    part["figures"].push_back(force);
  }
};

// --- Steps and rates ------------------------------------------------------------------------------------------------

void steps(ordered_json& part, bool quick) {
  const int rounds = quick ? 1 : 3;
  Charts charts("one_loop", "Steps of the one loop", "time.step",
                fmt::format("The error goes with the step; above 1 ms it jumps in the grasps, for control is coarser "
                            "there, too. One loop does everything at every step; control as often as the scene has it "
                            "(1 ms), or every step if that is longer. 1 ms is the default. Against steps of {:g} µs "
                            "with control as often as the scene has it. Down and left is better.",
                            1e6 * kReference_s),
                runs_of(rounds));
  for (const Scenario& scenario : kAll) {
    const Scene scene = scene_of(scenario);
    const double period_s = scene.control ? scene.control_period_s : kReference_s;
    const Course course(scene, {kReference_s, period_s}, scenario.start_s, scenario.from_s, scenario.end_s(quick));
    std::vector<Way> ways;
    for (const double step_s : {20e-3, 10e-3, 5e-3, 2e-3, 1e-3, 0.5e-3, 0.25e-3, 0.1e-3}) {
      if (quick && step_s < 0.2e-3) continue;
      const Timing timing{step_s, std::max(step_s, scene.control_period_s)};
      ways.push_back({"one loop", fmt::format("{:g} ms", 1e3 * step_s), step_s == scene.step_s,
                      [&course, timing] { return course.in_one_loop(timing); }});
    }
    measure_against(course.in_one_loop({kReference_s, period_s}), ways, rounds);
    charts.add(scene.name, ways);
  }
  charts.add_to(part);
}

/// One loop with the finest steps, and the control period and delay of the two loops: what the two should do.
Timing finest(const Scene& scene, double period_s) {
  return scene.control ? Timing{kReference_s, period_s, period_s} : Timing{kReference_s, kReference_s};
}

void contact_rates(ordered_json& part, bool quick) {
  const int rounds = quick ? 1 : 3;
  Charts charts(
      "contact_rate", "Contact rate of the two loops", "contact rate",
      fmt::format("With control as often, a faster contact loop comes nearer to the finest one at a cost that "
                  "grows more slowly than the rate. Contact at 1, 2, 4 and 10 kHz, from the left; 4 kHz, the "
                  "default of real-time runs, is a haptic device's rate with room. Control and frames at "
                  "1 kHz, which come into use 1 ms after their snapshot. Against one loop with steps of "
                  "{:g} µs that has the same control period and delay. Down and left is better.",
                  1e6 * kReference_s),
      runs_of(rounds));
  for (const Scenario& scenario : kAll) {
    const Scene scene = scene_of(scenario);
    const Timing reference = finest(scene, kControl_s);
    const Course course(scene, reference, scenario.start_s, scenario.from_s, scenario.end_s(quick));
    std::vector<Way> ways;
    for (const double step_s : {1e-3, 0.5e-3, kContact_s, 0.1e-3}) {
      const Timing timing{step_s, kControl_s, kControl_s};
      ways.push_back({"two loops", "contact at " + rate(step_s), step_s == kContact_s,
                      [&course, timing] { return course.split(timing); }});
    }
    measure_against(course.in_one_loop(reference), ways, rounds);
    charts.add(scene.name, ways);
  }
  charts.add_to(part);
}

/// How far the object is from where it should be, rms.
PathError off_target(const Path& path, const Model& model) {
  double sum_m2 = 0.0, ticks = 0.0;
  for (std::size_t i = 0; i < path.X_WO.size(); ++i) {
    if (path.time_s(i) <= path.from_s) continue;
    sum_m2 += (path.X_WO[i].translation() - model.target(path.time_s(i)).translation()).squaredNorm();
    ++ticks;
  }
  return {.position_m = std::sqrt(sum_m2 / ticks)};
}

void control_rates(ordered_json& part, bool quick) {
  const int rounds = quick ? 1 : 3;
  ordered_json figure = chart(
      "control_rate", "Control rate of the two loops", "control rate",
      "From 50 Hz to 2 kHz the object comes three to eight times nearer to its target, at some twice the cost. Error: "
      "how far it is from its target while it is held and moved, what a user sees of the control rate. Control at 50, "
      "100, 200, 500 Hz, 1 and 2 kHz, from the left; 1 kHz is the default of real-time runs. Contact at 4 kHz; a frame "
      "comes into use a control period after its snapshot, and the force gain goes with the control rate, as scenes "
      "have it that name none. An object more than 5 mm off is lost, and has no error. Down and left is better.",
      runs_of(rounds), "rms distance from the target [µm]");
  for (const Scenario& scenario : kControlled) {
    const Scene scene = scene_of(scenario);
    const Course course(scene, finest(scene, kControl_s), scenario.start_s, scenario.from_s, scenario.end_s(quick));
    std::vector<Way> ways;
    for (const double period_s : {20e-3, 10e-3, 5e-3, 2e-3, kControl_s, 0.5e-3}) {
      const Timing timing{kContact_s, period_s, period_s};
      ways.push_back({"two loops", "control at " + rate(period_s), period_s == kControl_s,
                      [&course, timing] { return course.split(timing); }});
    }
    measure(ways, rounds, [&](const Path& path) { return off_target(path, course.reference_model); });
    add_case(figure, scene.name, ways, [](const PathError& error) { return 1e6 * error.position_m; });
  }
  part["figures"].push_back(figure);
}

// --- What the split adds --------------------------------------------------------------------------------------------

void hand_over(ordered_json& part, bool quick) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  ordered_json rows = ordered_json::array();
  std::vector<double> jump_N, off_m;  // Of slide at the longest period, with the offset and without.
  for (const Scenario& scenario : {kSlide, kBoxGrasp}) {
    const Scene scene = scene_of(scenario);
    for (const double period_s : {kControl_s, 5e-3, 20e-3}) {
      const Timing reference = finest(scene, period_s);
      const Course course(scene, reference, scenario.start_s, scenario.from_s, scenario.end_s(quick));
      const Path fine = course.in_one_loop(reference);
      for (const bool offset : {true, false}) {
        const Path path = course.split({kContact_s, period_s, period_s}, offset);
        const PathError error = path_error(path, fine);
        rows.push_back({scene.name, 1e3 * period_s, offset ? "on" : "off", 1e6 * error.position_m,
                        1e3 * error.rotation_rad / kDegree, 1e3 * error.force_N, 1e3 * path.handover_step_N,
                        1e3 * path.ordinary_step_N, path.injected_J / path.dissipated_J});
        if (scene.control || period_s < 20e-3) continue;
        jump_N.push_back(path.handover_step_N);
        off_m.push_back(error.position_m);
      }
    }
  }
  ordered_json& figure = add_figure(
      part, "table", "hand_over", "What the split alone adds, with and without the offset at hand-overs",
      fmt::format(
          "The offset takes the jump of the force at a new frame down {:.0f} times (slide, 20 ms) and makes the error "
          "of the path {:.1f} times as large; on the box's flat faces, whose gaps hardly change from frame to frame, "
          "it changes little up to 5 ms. Two loops, contact at 4 kHz, against one loop with steps of {:g} µs that has "
          "the same control period and delay. Offset: gaps agree at a hand-over and move on to the new frame's in a "
          "control period; on is the default. Step of the force: the largest change of a finger's force from tick to "
          "tick, where a new frame comes into use and elsewhere. Injected: work that contact did on the bodies, over "
          "what it took from them; 0 is passive.",
          jump_N[1] / jump_N[0], off_m[0] / off_m[1], 1e6 * kReference_s),
      "deterministic");
  figure["columns"] = {
      "scene",      "frames every [ms]",      "offset",         "position [µm]",      "rotation [mdeg]",
      "force [mN]", "step at new frame [mN]", "step else [mN]", "injected/dissipated"};
  figure["rows"] = rows;
}

// --- Settings -------------------------------------------------------------------------------------------------------

Path run_scene(const Model& model, const Scenario& scenario, bool quick) {
  State state(model);
  return run_in_one_loop(model, state, scenario.from_s, scenario.end_s(quick));
}

Way changed(const Model& known, const Scenario& scenario, bool quick, const std::string& method,
            const std::string& setting, const std::vector<std::string>& changes) {
  auto model = std::make_shared<const Model>(build_model(scene_of(scenario, changes), known));
  return {method, setting, false,
          [model = std::move(model), &scenario, quick] { return run_scene(*model, scenario, quick); }};
}

void tolerances(ordered_json& part, bool quick) {
  const int rounds = quick ? 3 : 5;  // A few per cent are to be seen.
  Charts charts(
      "tolerance", "Tolerance of the contact solve", "contact.tolerance",
      "From 1e-4 on each digit takes the error down some ten times and adds a few per cent to a tick; at 1e-7, "
      "the default, the solve adds nanometres, far less than steps and control points do. One loop at the "
      "scene's own step, against the same scene solved to 1e-11. Down and left is better.",
      runs_of(rounds));
  for (const Scenario& scenario : kTolerances) {
    const Model known = build_model(scene_of(scenario));
    const Way fine = changed(known, scenario, quick, "", "", {"contact.tolerance=1e-11", "contact.max_sweeps=3000"});
    std::vector<Way> ways;
    for (const int digits : {2, 3, 4, 5, 6, 7, 9}) {
      const std::string tolerance = fmt::format("1e-{}", digits);
      ways.push_back(changed(known, scenario, quick, "contact.tolerance", tolerance,
                             {"contact.tolerance=" + tolerance, "contact.max_sweeps=1000"}));
      ways.back().is_default = digits == 7;
    }
    measure_against(fine.run(), ways, rounds);
    charts.add(known.scene.name, ways);
  }
  charts.add_to(part);
}

/// So many control points, and contacts in proportion.
std::vector<std::string> with_leaves(int leaves) {
  return {fmt::format("fingertips.leaves={}", leaves), fmt::format("fingertips.points={}", leaves * 15 / 2),
          fmt::format("contact.max_per_finger={}", leaves / 16)};
}

void details(ordered_json& part, bool quick) {
  constexpr int kFinest = 1280;
  const int rounds = quick ? 1 : 3;
  Charts charts(
      "detail", "Contacts a finger, and leaves", "",
      fmt::format(
          "Leaves buy accuracy at a cost that grows about with their number; fewer than 20 contacts a finger cost "
          "accuracy on box grasp and capsule, and more than 20 buy nothing. A scene must name both, there is no "
          "default. One of them at a time differs from the scene's 20 contacts a finger and 320 leaves; with other "
          "numbers of leaves there are as many contacts in proportion. One loop at the scene's own step, against {} "
          "leaves and up to {} contacts a finger, solved to 1e-10. Down and left is better.",
          kFinest, kFinest / 16),
      runs_of(rounds));
  for (const Scenario& scenario : kDetailed) {
    const Model known = build_model(scene_of(scenario));
    std::vector<std::string> changes = with_leaves(kFinest);
    changes.insert(changes.end(), {"contact.tolerance=1e-10", "contact.max_sweeps=2000"});
    const Way fine = changed(known, scenario, quick, "", "", changes);
    std::vector<Way> ways;
    for (const int most : {3, 5, 10, 20, 40}) {
      ways.push_back(changed(known, scenario, quick, "contact.max_per_finger",
                             fmt::format("{} contacts a finger", most),
                             {fmt::format("contact.max_per_finger={}", most)}));
    }
    for (const int leaves : {80, 160, 320, 640}) {
      ways.push_back(
          changed(known, scenario, quick, "fingertips.leaves", fmt::format("{} leaves", leaves), with_leaves(leaves)));
    }
    measure_against(fine.run(), ways, rounds);
    charts.add(known.scene.name, ways);
  }
  charts.add_to(part);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "rate", "Steps, rates and settings for the whole grasp",
                  "What a coarser or finer run of the same scene costs, and how far it takes the object and the forces "
                  "from the finest one. Stick: three fingertips press on a box that a spring carries and turns; slide: "
                  "a ball is dragged along a fingertip; nobody controls either. Box grasp, box turn, capsule, mug: "
                  "held and moved by the controlled hand. Where contacts stick, they remember the order in which they "
                  "touched, which another step takes in another order: stick and slide go on from one state; the "
                  "grasps begin anew, and differ by that, too. All on a virtual clock: errors are the same in every "
                  "run.",
                  {steps, contact_rates, control_rates, hand_over, tolerances, details});
}
