// SPDX-License-Identifier: Apache-2.0
#include "bench/report/outcome_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "bench/report/figure.h"
#include "engine/sweeps/sweep.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

Variation variation(const MapAxis& axis, int count) {
  Variation vary{axis.key, {}};
  for (const double value : axis.values(count)) {
    vary.values.push_back(axis.written           ? axis.written(value)
                          : axis.unit == "count" ? fmt::format("{:.0f}", value)
                                                 : fmt::format("{:.6g} {}", value, axis.unit));
  }
  return vary;
}

ordered_json shown(const MapAxis& axis, int count) {
  ordered_json values = ordered_json::array();
  for (const double value : axis.values(count)) values.push_back(axis.show(value));
  return {{"label", axis.label}, {"values", values}, {"log", true}};
}

bool is_finite(const TickRecord& tick) {
  return tick.position_m.allFinite() && std::isfinite(tick.rotation_error_rad) &&
         std::ranges::all_of(tick.force, [](const auto& force) {
           return std::isfinite(force.normal_N) && std::isfinite(force.tangential_N);
         });
}

ordered_json cell(const Verdict& verdict) {
  return {{"outcome", to_string(verdict.outcome)}, {"reason", verdict.reason}};
}

/// The cells of a panel, rows by y; and how many are held.
int put_cells(const std::vector<SweepRow>& rows, std::size_t panel, int count, ordered_json& cells) {
  int held = 0;
  for (int iy = 0; iy < count; ++iy) {
    ordered_json line = ordered_json::array();
    for (int ix = 0; ix < count; ++ix) {
      const SweepRow& row = rows[static_cast<std::size_t>(iy * count + ix)];
      line.push_back(row.verdict.outcome == Outcome::kRefused ? cell(row.verdict) : row.measures.at(panel));
      held += line.back()["outcome"] == to_string(Outcome::kHeld) ? 1 : 0;
    }
    cells.push_back(line);
  }
  return held;
}

ordered_json limits(const MapPanel& panel) {
  ordered_json lines = ordered_json::array();
  for (const MapLimit& limit : panel.limits) lines.push_back({{"label", limit.label}, {"x", limit.x}, {"y", limit.y}});
  return lines;
}

}  // namespace

std::vector<double> equal_ratios(double low, double high, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(low * std::pow(high / low, static_cast<double>(i) / (count - 1)));
  return values;
}

Verdict run_and_judge(const Model& model, const std::function<Recording(const Model&)>& run) {
  const Recording recording = run(model);
  const Verdict judged = recording.verdict;
  const bool silent = judged.outcome == Outcome::kHeld
                          ? recording.ticks.empty() || !std::ranges::all_of(recording.ticks, is_finite)
                          : judged.reason.empty();
  if (silent) throw std::logic_error("a grasp failed without a reason");
  return judged;
}

void add_map(ordered_json& part, const OutcomeMap& map, int count) {
  const SweepPlan plan{std::string(THENAR_CONFIGS) + "/" + map.scene + ".yaml",
                       map.overrides,
                       {variation(map.y, count), variation(map.x, count)}};
  std::vector<std::size_t> order(plan.rows());
  std::iota(order.begin(), order.end(), 0);
  std::vector<SweepRow> rows(plan.rows());
  const auto run = [&](const Model& model) {
    SweepRow row;
    Model own = model;
    if (map.adapt) map.adapt(own);
    for (const MapPanel& panel : map.panels) row.measures.push_back(cell(run_and_judge(own, panel.run)));
    return row;
  };
  run_sweep(plan, order, static_cast<int>(std::thread::hardware_concurrency()), run,
            {[&](std::size_t row, SweepRow result) { rows[row] = std::move(result); },
             [](std::size_t, const std::string& why) { throw std::runtime_error(why); }});

  std::string caption = map.caption + " Cells held:";
  ordered_json panels = ordered_json::array();
  for (std::size_t p = 0; p < map.panels.size(); ++p) {
    const MapPanel& panel = map.panels[p];
    ordered_json cells = ordered_json::array();
    const int held = put_cells(rows, p, count, cells);
    caption += fmt::format("{} {} {} of {}", p > 0 ? "," : "", panel.name, held, count * count);
    panels.push_back({{"name", panel.name}, {"ours", panel.ours}, {"cells", cells}, {"limits", limits(panel)}});
  }
  ordered_json& figure = add_figure(part, "map", map.id, map.title, caption + ".",
                                    "One deterministic run a cell on a virtual clock: no times are measured.");
  figure["x"] = shown(map.x, count);
  figure["y"] = shown(map.y, count);
  figure["panels"] = panels;
  figure["reference"] = map.reference ? ordered_json(*map.reference) : ordered_json(nullptr);
}

}  // namespace thenar
