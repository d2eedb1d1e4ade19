// SPDX-License-Identifier: Apache-2.0
#include "bench/report/touch_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "bench/report/figure.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

using nlohmann::ordered_json;

Scene coarse_scene(const std::string& name, Texts changes) {
  changes.emplace_back("object.points=6000");
  return load_scene(std::string(THENAR_CONFIGS) + "/" + name + ".yaml", changes);
}

Recording run(const Model& model) {
  State state(model);
  return run_scene(model, state);
}

Recording run(const std::string& name, const Texts& changes) { return run(build_model(coarse_scene(name, changes))); }

Texts late(double ms, Texts more) {
  more.push_back(fmt::format("control.feedback_delay={:g} ms", ms));
  more.push_back(fmt::format("fingertips.touch.delay={:g} ms", ms));
  return more;
}

double slip_mm(const Recording& recording, double until_s) {
  const auto after = std::ranges::find_if(recording.ticks, [&](const TickRecord& t) { return t.time_s > until_s; });
  const TickRecord& last = after == recording.ticks.begin() ? *after : *std::prev(after);
  double most = 0.0;
  for (std::size_t k = 0; k < last.slip_m.size(); ++k) most = std::max(most, last.slip_m[k] - last.start_slip_m[k]);
  return 1e3 * most;
}

void add_run_curves(ordered_json& part, const std::string& id, const std::string& title, const std::string& caption,
                    const std::string& x, const std::string& y, const ordered_json& panels) {
  ordered_json& figure = add_figure(part, "curves", id, title, caption,
                                    "One deterministic run a point on a virtual clock: no times are measured.");
  figure["x"] = {{"label", x}, {"log", false}};
  figure["y"] = {{"label", y}, {"log", false}};
  figure["panels"] = panels;
}

}  // namespace thenar
