// SPDX-License-Identifier: Apache-2.0
// How time and memory grow with what a scene is made of: contacts, samples of the object, control points.

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "bench/methods/contact_computation.h"
#include "bench/methods/finding_methods.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"
#include "engine/grasp/stopwatch.h"
#include "engine/models/build_model.h"
#include "engine/scenes/scene_file.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using nlohmann::ordered_json;

struct Curve {
  std::string name;
  std::vector<double> x = {}, y = {};
};

ordered_json panel(const std::string& name, const std::vector<Curve>& curves) {
  ordered_json json{{"name", name}, {"curves", ordered_json::array()}};
  for (const Curve& c : curves) json["curves"].push_back(curve(c.name, c.x, c.y));
  return json;
}

ordered_json& add_curves(ordered_json& part, const std::string& id, const std::string& title,
                         const std::string& caption, const std::string& runs, const std::string& x,
                         const std::string& y) {
  ordered_json& figure = add_figure(part, "curves", id, title, caption, runs);
  figure["x"] = {{"label", x}, {"log", true}};
  figure["y"] = {{"label", y}, {"log", true}};
  figure["panels"] = ordered_json::array();
  return figure;
}

std::string rounds_of(int count) { return count == 1 ? "one round" : fmt::format("{} rounds", count); }

// --- Contacts -------------------------------------------------------------------------------------------------------

void contacts(ordered_json& part, bool quick) {
  const int turns = quick ? 4 : 20;
  ordered_json& figure = add_curves(
      part, "growth_computation", "A contact computation over the number of contacts",
      "At some ten contacts finding them takes the largest part; at hundreds the solve, the compliance and the "
      "deformation do, which grow nearly with the square. The box grasp on its way, every contact solve to a residual "
      "of 1e-6 from the last tick's forces. Above 60 contacts the fingertips have so many more control points and "
      "samples, so that finding and display grow, too. Contacts are found and their compliance made once a control "
      "period; assembling (gaps, Jacobians), solving and deforming are done in every contact tick; the display is a "
      "viewer's.",
      fmt::format("medians of {} ticks of each size, which took turns of {} ticks, the first {} of a turn dropped",
                  turns * (kTicksATurn - kDroppedTicks), kTicksATurn, kDroppedTicks),
      "contacts", "time [µs]");
  std::vector<Index> sizes{15, 30, 60, 120, 240};
  if (!quick) sizes.push_back(501);
  std::deque<ContactRun> runs;
  for (const Index size : sizes) runs.emplace_back(size, 1000);
  const std::vector<std::vector<ContactComputation>> ticks = in_turns(runs, turns);
  using Tick = ContactComputation;
  const auto stage = [&](const std::string& name, auto seconds) {
    Curve result{name};
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      std::vector<double> us;
      for (const Tick& tick : ticks[k]) us.push_back(1e6 * seconds(tick));
      result.x.push_back(static_cast<double>(sizes[k]));
      result.y.push_back(percentiles(std::move(us)).p50);
    }
    return result;
  };
  figure["panels"].push_back(panel("box grasp", {stage("in all", [](const Tick& t) { return t.total_s(); }),
                                                 stage("find", [](const Tick& t) { return t.find_s; }),
                                                 stage("compliance", [](const Tick& t) { return t.compliance_s; }),
                                                 stage("assemble", [](const Tick& t) { return t.assemble_s; }),
                                                 stage("solve", [](const Tick& t) { return t.solve_s; }),
                                                 stage("deform", [](const Tick& t) { return t.deform_s; }),
                                                 stage("display", [](const Tick& t) { return t.display_s; })}));
}

// --- Samples of the object ------------------------------------------------------------------------------------------

void samples(ordered_json& part, bool quick) {
  const int rounds = quick ? 1 : 4;
  std::vector<double> finer{0.53, 1.0, 1.7, 3.0};  // of 36 000 samples: 10 000, 36 000, 100 000, 330 000
  if (!quick) finer.push_back(5.25);               // 1 000 000
  const Matrix3Xd controls_m = pulp_control_points(320);
  const GripTask task;
  std::vector<ordered_json> times, memories;
  for (const bool box : {true, false}) {
    const auto make = [&](double by) {
      return box ? known_box(std::lround(77 * by)) : known_scan(std::lround(61 * by));
    };
    const KnownObject reference = make(1.0);
    const std::vector<Grip> grips = random_grips(reference, controls_m, task, 32, 1);
    const std::vector<Grip> creeping = creeping_grip(grips.front(), 64, 1);
    std::vector<FindingCase> cases;
    Curve cold{"find, nothing remembered"}, warm{"find, a grip that creeps"}, ready{"make ready"}, memory{"surface"};
    for (const double by : finer) {
      const KnownObject object = make(by);
      const auto n = static_cast<double>(object.cloud.points_m.cols());
      for (Curve* curve : {&cold, &warm, &ready, &memory}) curve->x.push_back(n);
      cases.push_back({our_finding(object, controls_m, task, true), grips});
      ready.y.push_back(1e3 * cases.back().method.prepare_ms);
      memory.y.push_back(cases.back().method.memory_MB);
      cases.push_back({our_finding(object, controls_m, task, false), creeping});
    }
    const std::vector<FindingRecord> records = measure_findings(cases, reference, controls_m, task, rounds);
    for (std::size_t k = 0; k < finer.size(); ++k) {
      cold.y.push_back(records[2 * k].us_p50);
      warm.y.push_back(records[2 * k + 1].us_p50);
    }
    times.push_back(panel(reference.name, {ready, cold, warm}));
    memories.push_back(panel(reference.name, {memory}));
  }
  const std::string runs = fmt::format(
      "finding: medians over 32 random and 126 creeping grips in {}, all sizes in turns; making ready: once",
      rounds_of(rounds));
  ordered_json& time = add_curves(part, "samples", "Contact finding over the samples of the object",
                                  "A hundred times the samples take finding less than ten times as long. "
                                  "Three fingertips of 320 control points, up to 20 contacts each, on a box of 50 mm "
                                  "and on a bumpy ellipsoid (scan). Finding runs once a control period, making ready "
                                  "once at the start. A held object creeps by micrometres: what is remembered from the "
                                  "last grip then spares most searches.",
                                  runs, "samples of the object", "time [µs]");
  time["panels"] = times;
  ordered_json& memory = add_curves(part, "samples_memory", "Memory over the samples of the object",
                                    "Memory goes with the samples: some 450 bytes each. What the object's surface "
                                    "takes on the heap, ready to be asked for distances: samples, blocks, starts, "
                                    "patches.",
                                    "one run", "samples of the object", "memory [MB]");
  memory["panels"] = memories;
}

// --- Control points -------------------------------------------------------------------------------------------------

void controls(ordered_json& part, bool quick) {
  const int rounds = quick ? 1 : 4;
  std::vector<Index> sizes{160, 320, 640, 1280};
  if (!quick) sizes.insert(sizes.end(), {2560, 5120});
  const KnownObject object = known_scan(61);
  const GripTask task;
  Curve cold{"find, nothing remembered"}, warm{"find, a grip that creeps"}, make{"make a fingertip"},
      memory{"a fingertip"};
  for (const Index size : sizes) {
    const Matrix3Xd controls_m = pulp_control_points(size);
    const std::vector<Grip> grips = random_grips(object, controls_m, task, 32, 1);
    const std::vector<FindingCase> cases{
        {our_finding(object, controls_m, task, true), grips},
        {our_finding(object, controls_m, task, false), creeping_grip(grips.front(), 64, 1)}};
    const std::vector<FindingRecord> records = measure_findings(cases, object, controls_m, task, rounds);
    for (Curve* curve : {&cold, &warm, &make, &memory}) curve->x.push_back(static_cast<double>(size));
    cold.y.push_back(records[0].us_p50);
    warm.y.push_back(records[1].us_p50);
    FindingMethod taken;
    const Pulp pulp = made_ready(taken, [&] {
      return make_spherical_pulp(Vector3d::Zero(), 8e-3, size * 15 / 2, size, {.reduced_modulus_Pa = 0.24e6});
    });
    make.y.push_back(1e3 * taken.prepare_ms);
    memory.y.push_back(taken.memory_MB);
  }
  ordered_json& time = add_curves(
      part, "controls", "Contact finding and start-up over the control points",
      "Making a fingertip grows faster than its control points (their compliance is a square), finding no faster. "
      "Three fingertips on the scan of 37 000 samples: finding up to 20 contacts each, whatever the number of control "
      "points; and making one fingertip, once at the start.",
      fmt::format("finding: medians over 32 random and 126 creeping grips in {}; making: once", rounds_of(rounds)),
      "control points of a fingertip", "time [µs]");
  time["panels"].push_back(panel("scan", {make, cold, warm}));
  ordered_json& memories = add_curves(part, "controls_memory", "Memory over the control points",
                                      "A fingertip's memory is the kernel among all its control points, a square; its "
                                      "samples and its tree are little beside it. On the heap, ready for use.",
                                      "one run", "control points of a fingertip", "memory [MB]");
  memories["panels"].push_back(panel("fingertip", {memory}));
}

// --- Start ----------------------------------------------------------------------------------------------------------

/// Seconds from now on, stage by stage.
class StageTimes {
 public:
  void begins(const char* stage) {
    end();
    stage_ = stage;
  }
  void end() {
    const double s = watch_.lap();
    if (stage_ != nullptr) seconds_[stage_] += s;
  }
  [[nodiscard]] double of(const std::string& stage) const { return seconds_.at(stage); }

 private:
  Stopwatch watch_;
  const char* stage_ = nullptr;
  std::map<std::string, double> seconds_;
};

/// The least times of the stages, and of all together, of three starts of a scene.
std::vector<double> least_start_ms(const std::string& file, const std::vector<std::string>& changes,
                                   const std::vector<std::string>& stages) {
  std::vector<double> least_ms(stages.size() + 1, std::numeric_limits<double>::infinity());
  for (int k = 0; k < 3; ++k) {
    StageTimes times;
    Stopwatch all;
    const Model model = build_model(load_scene(file, changes), [&](const char* stage) { times.begins(stage); });
    times.end();
    least_ms.back() = std::min(least_ms.back(), 1e3 * all.lap());
    for (std::size_t s = 0; s < stages.size(); ++s) least_ms[s] = std::min(least_ms[s], 1e3 * times.of(stages[s]));
  }
  return least_ms;
}

void start(ordered_json& part, bool quick) {
  const std::vector<std::string> stages{"the object's samples", "faults among the samples", "the object's surface",
                                        "patches of the surface", "the fingertips"};
  const std::vector<std::string> many{"fingertips.points=9600", "fingertips.leaves=1280"};
  struct Start {
    std::string name, scene;
    std::vector<std::string> changes = {};
  };
  std::vector<Start> starts{{"box_grasp, 36 000 samples", "box_grasp"},
                            {"bunny, a scan", "bunny"},
                            {"box_grasp, 1280 control points a finger", "box_grasp", many}};
  if (!quick) starts.push_back({"box_grasp, 300 000 samples", "box_grasp", {"object.points=300000"}});
  ordered_json& figure = add_figure(
      part, "table", "start", "The start of a scene, by stages",
      "Reading it, drawing the object's samples (or reading a scan's), looking for faults among them, the surface that "
      "they stand for, its patches, and the fingertips with their compliance. Once, before the first tick; from the "
      "second second on, a line says which stage is under way.",
      "the least of three starts");
  figure["columns"] = {"scene"};
  for (const std::string& stage : stages) figure["columns"].push_back(stage + " [ms]");
  figure["columns"].push_back("in all [ms]");
  for (const Start& scene : starts) {
    const std::string file = std::string(THENAR_CONFIGS) + "/" + scene.scene + ".yaml";
    const Shape shape = load_scene(file).object.shape;
    if (const auto* cloud = std::get_if<CloudShape>(&shape);
        cloud != nullptr && !std::filesystem::exists(cloud->file)) {
      figure["caption"] = figure["caption"].get<std::string>() + " Not here, and not measured: " + scene.name + ".";
      continue;
    }
    ordered_json row{scene.name};
    for (const double ms : least_start_ms(file, scene.changes, stages)) row.push_back(ms);
    figure["rows"].push_back(row);
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "growth", "Growth",
                  "Time and memory against the size of a scene. The number beside a curve is p of n^p, fitted to the "
                  "upper half of the sizes.",
                  {contacts, samples, controls, start});
}
