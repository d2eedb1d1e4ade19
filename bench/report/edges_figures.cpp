// SPDX-License-Identifier: Apache-2.0
// What a hand gets back that takes an object over a pulp, across edges, corners and rims, and how evenly it goes.
//   edges_figures [--quick] FILE.json

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "bench/cases/edge_ways.h"
#include "bench/report/figure.h"
#include "bench/report/outcome_map.h"

namespace thenar {
namespace {

using Eigen::Index;
using nlohmann::ordered_json;
using truth::EdgeWay, truth::Probe, truth::Taken;

constexpr const char* kText =
    "A pulp without friction that an object presses and that it leaves again has no energy of its own: the hand that "
    "moved the object gets back what it gave. An object is pressed into a pulp of 8 mm, dragged over an edge, a corner "
    "or a rim, and lifted. Its work is that of the forces along the positions; the engine's ledger has no part in it.";

/// What drags along all ways were, over some x.
using Drags = std::vector<std::vector<Taken>>;

Drags drag(const std::vector<double>& x, const std::function<Taken(const EdgeWay&, double)>& along) {
  const std::vector<EdgeWay> ways = truth::edge_ways();
  Drags drags(ways.size(), std::vector<Taken>(x.size()));
  tbb::parallel_for(std::size_t{0}, ways.size() * x.size(), [&](std::size_t i) {
    drags[i / x.size()][i % x.size()] = along(ways[i / x.size()], x[i % x.size()]);
  });
  return drags;
}

/// A panel of curves over x, one a way.
void add_panel(ordered_json& figure, const std::string& name, const std::vector<double>& x, double x_unit,
               const Drags& drags, double (*measure)(const Taken&)) {
  std::vector<double> shown;
  for (const double value : x) shown.push_back(value / x_unit);
  std::vector<ordered_json> curves;
  for (std::size_t w = 0; w < drags.size(); ++w) {
    std::vector<double> values;
    for (const Taken& taken : drags[w]) values.push_back(measure(taken));
    curves.push_back(plain_curve(truth::edge_ways()[w].name, shown, values));
  }
  figure["panels"].push_back({{"name", name}, {"curves", curves}});
}

double lost(const Taken& taken) { return std::abs(taken.work_J) / taken.stored_J; }
double step(const Taken& taken) { return taken.step_N / taken.largest_N; }

void depths(ordered_json& part, bool quick) {
  const std::vector<double> depths_m = equal_ratios(0.3e-3, 3e-3, quick ? 3 : 7);
  struct Panel {
    Index leaves;
    double friction;
    Drags drags;
  };
  std::vector<Panel> panels = {{320, 0.0, {}}, {320, 0.8, {}}};
  if (!quick) panels.push_back({1280, 0.0, {}});
  for (Panel& panel : panels) {
    panel.drags = drag(depths_m, [&](const EdgeWay& way, double depth_m) {
      Probe probe{.shape = way.shape};
      probe.leaves = panel.leaves;
      probe.friction = panel.friction;
      return take(way, depth_m, probe);
    });
  }
  const auto add = [&](const char* id, const char* title, const char* caption, const char* label,
                       double (*measure)(const Taken&), bool with_friction) {
    ordered_json& figure = add_figure(part, "curves", id, title, caption, "deterministic");
    figure["x"] = {{"label", "depth [mm]"}, {"log", true}};
    figure["y"] = {{"label", label}, {"log", true}};
    for (const Panel& panel : panels) {
      if (panel.friction > 0.0 && !with_friction) continue;
      const std::string friction = panel.friction > 0.0 ? fmt::format(", friction {}", panel.friction) : "";
      add_panel(figure, fmt::format("{} control points{}", panel.leaves, friction), depths_m, 1e-3, panel.drags,
                measure);
    }
  };
  add("edge_work", "What closed ways cost",
      "The work of a way, over the most energy that the pulp held, at 5 um a tick. Exact is none.",
      "work over stored energy", lost, false);
  add("edge_steps", "How evenly a drag goes",
      "The largest change of the force in a tick of 5 um, over the largest force.", "step over the largest force", step,
      true);
}

/// Where it fails: cells are looked at once a frame, and change under it.
void frames(ordered_json& part, bool quick) {
  ordered_json& figure = add_figure(
      part, "curves", "edge_frames", "Where edges fail: ways that are long for a frame",
      "The work of a way 1 mm deep, over the most energy that the pulp held, against how far the object goes while one "
      "frame is used, at 5 um a tick and with frames that are ever later. A cell is 1.6 mm wide. Above 0.02 the loop "
      "does not hold.",
      "deterministic");
  figure["x"] = {{"label", "way in a frame [um]"}, {"log", true}};
  figure["y"] = {{"label", "work over stored energy"}, {"log", true}};
  const std::vector<double> ways_m =
      quick ? std::vector{5e-6, 50e-6} : std::vector{5e-6, 10e-6, 25e-6, 50e-6, 100e-6, 200e-6, 400e-6};
  const Drags drags = drag(ways_m, [](const EdgeWay& way, double way_m) {
    Probe probe{.shape = way.shape};
    probe.frame_s = 1e-3 * std::round(way_m / 5e-6);
    return take(way, 1e-3, probe);
  });
  add_panel(figure, "frames of 1 to 80 ms", ways_m, 1e-6, drags, lost);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  return thenar::run_part(argc, argv, "edges", "Edges, corners and rims", thenar::kText,
                          {thenar::depths, thenar::frames});
}
