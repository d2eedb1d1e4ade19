// SPDX-License-Identifier: Apache-2.0
// At which delays and gains the loop of the object's pose swings, against the limits of a delayed integrator.
//   pose_loop_figures [--quick] FILE.json

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bench/report/figure.h"
#include "bench/report/outcome_map.h"
#include "bench/report/touch_runs.h"
#include "engine/control/pose_loop.h"
#include "engine/models/build_model.h"
#include "engine/scenes/scene_file.h"

namespace thenar {
namespace {

using nlohmann::ordered_json;

const MapAxis kDelay{"control.feedback_delay", "ms", 10.0, 200.0, "delay of the pose [ms]"};
const MapAxis kGain{"control.position.p", "N/m", 30.0, 2000.0, "gain p of the position [N/m]"};
constexpr double kNudged_s = 0.9;  // When the nudge has ended.

const std::vector<std::string> kNudge = {"object.points=6000", "task.lost=20 mm",
                                         "task.push={force: [0.1 N, 0.1 N, 0.1 N], from: 0.8 s, over: 0.1 s}"};

/// Returns the largest stable gain p of the position of the scene with a pose known this late.
double most_gain(const PoseLoop& loop, const Scene& scene, double delay_ms) {
  const int steps = static_cast<int>(std::lround(1e-3 * delay_ms / scene.step_s));
  return scene.control->position.p * loop.most_gain(pose_gains(scene), steps, PoseLoop::Of::kPosition);
}

/// The line of the largest stable gains.
MapLimit limit(const Model& model, int count) {
  const PoseLoop loop(model);
  MapLimit line{"largest pole 1: swings wider beyond", {}, {}};
  for (const double delay_ms : kDelay.values(2 * count)) {
    const double p = most_gain(loop, model.scene, delay_ms);
    if (p < kGain.low || p > kGain.high) continue;
    line.x.push_back(delay_ms);
    line.y.push_back(p);
  }
  return line;
}

/// How many cells the limit is wrong about, and where, in words; and where the border that was met lies against it.
std::string judged(const Model& model, const ordered_json& figure, int count) {
  const PoseLoop loop(model);
  int held_beyond = 0, failed_within = 0;
  double most = 0.0, ratios = 0.0;
  int borders = 0;
  const std::vector<double> ms = kDelay.values(count), p = kGain.values(count);
  std::string where;
  for (int ix = 0; ix < count; ++ix) {
    const double stable = most_gain(loop, model.scene, ms[ix]);
    for (int iy = 0; iy < count; ++iy) {
      const auto& cell = figure["panels"][0]["cells"][iy][ix];
      const bool held = cell["outcome"] == to_string(Outcome::kHeld);
      const double share = p[iy] / stable;
      if (iy > 0 && !held && figure["panels"][0]["cells"][iy - 1][ix]["outcome"] == to_string(Outcome::kHeld)) {
        ratios += std::log(std::sqrt(p[iy] * p[iy - 1]) / stable);
        ++borders;
      }
      if (held == (share <= 1.0)) continue;
      ++(held ? held_beyond : failed_within);
      if (held) most = std::max(most, share);
      if (!held) {
        where += fmt::format("{}{:.0f} ms and {:.0f} N/m ({}, {:.2f} of the limit)", where.empty() ? "" : "; ", ms[ix],
                             p[iy], cell["outcome"].get<std::string>(), share);
      }
    }
  }
  std::string words =
      fmt::format(" The limit is wrong about {} of {} cells.", held_beyond + failed_within, count * count);
  if (held_beyond > 0) words += fmt::format(" Held beyond it: {}, up to {:.2f} times.", held_beyond, most);
  if (failed_within > 0) words += fmt::format(" Not held within it: {}, at {}.", failed_within, where);
  if (borders > 0) {
    words += fmt::format(" The border that was met lies at {:.2f} of the limit, in the mean over {} delays.",
                         std::exp(ratios / borders), borders);
  }
  return words;
}

void add(ordered_json& part, bool quick) {
  const int count = quick ? 6 : 11;
  const Model model = build_model(load_scene(std::string(THENAR_CONFIGS) + "/box_load.yaml", kNudge));
  OutcomeMap map{
      "pose_delay",
      "Delay and gain of the pose's loop",
      "How late the object's pose is known against the gain that brings it back, for configs/box_load.yaml: what sets "
      "it off its target is the closing grip, and a nudge of 0.17 N for 0.1 s. The line is where the largest pole of "
      "the sampled loop reaches 1 (PoseLoop): object, fingers and pulps as a first-order plant, the PID, the grasp "
      "forces and the force control as the controller computes them, and the delay as stored commands; the gain of the "
      "rotation stays, and bends the line. A run lasts twelve delays after the nudge, and 0.6 s at least. From 0.8 of "
      "the line on `thenar check` warns.",
      kDelay,
      kGain,
      kNudge,
      [](Model& own) { own.scene.duration_s = kNudged_s + std::max(0.6, 12.0 * own.scene.control->feedback_delay_s); },
      {{"ours", true, [](const Model& own) { return run(own); }, {limit(model, count)}}},
      {{1e3 * model.scene.control->feedback_delay_s, model.scene.control->position.p}},
      "box_load"};
  add_map(part, map, count);
  ordered_json& figure = part["figures"].back();
  figure["caption"] = figure["caption"].get<std::string>() + judged(model, figure, count);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(
      argc, argv, "pose_loop", "Delay and gain",
      "The pose of the object is known late, by eyes or by cameras. How strongly it may be brought back then "
      "is the oldest limit of a loop.",
      {add});
}
