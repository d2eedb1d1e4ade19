// At which delays and gains the loop of the object's pose swings, against the limits of a delayed integrator.
//   pose_loop_figures [--quick] FILE.json

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
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

/// Rate times delay of the scene with another delay and gain.
double delays(Model& model, double delay_ms, double p) {
  model.scene.control->feedback_delay_s = 1e-3 * delay_ms;
  model.scene.control->position.p = p;
  return pose_rate(model) * loop_delay_s(model.scene);
}

/// Where rate times delay is this much.
MapLimit limit(Model model, double at, const std::string& label, int count) {
  MapLimit line{label, {}, {}};
  for (const double p : kGain.values(4 * count)) {
    const double none_ms = 0.0;
    const double own = delays(model, none_ms, p);  // With the half period, which is there without a delay, too.
    const double delay_ms = 1e3 * (at - own) / pose_rate(model);
    if (delay_ms < kDelay.low || delay_ms > kDelay.high) continue;
    line.x.push_back(delay_ms);
    line.y.push_back(p);
  }
  return line;
}

/// How many cells a limit is wrong about, and where, in words.
std::string judged(Model model, const ordered_json& figure, int count) {
  int held_beyond = 0, failed_within = 0;
  double most = 0.0;
  const std::vector<double> ms = kDelay.values(count), p = kGain.values(count);
  std::string where;
  for (int iy = 0; iy < count; ++iy) {
    for (int ix = 0; ix < count; ++ix) {
      const auto& cell = figure["panels"][0]["cells"][iy][ix];
      const bool held = cell["outcome"] == to_string(Outcome::kHeld);
      const double share = delays(model, ms[ix], p[iy]) / kMostDelay;
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
  return words;
}

void add(ordered_json& part, bool quick) {
  const int count = quick ? 6 : 11;
  const Model model = build_model(load_scene(std::string(THENAR_CONFIGS) + "/box_load.yaml", kNudge));
  OutcomeMap map{
      "pose_delay",
      "Delay and gain of the pose's loop",
      "How late the object's pose is known against the gain that brings it back, for configs/box_load.yaml: what sets "
      "it "
      "off its target is the closing grip, and a nudge of 0.17 N for 0.1 s. With x' = -k x(t - T) there is no "
      "overshoot "
      "below k T = 1/e; it rings and comes back up to π/2, and swings wider and wider beyond. k is the largest "
      "eigenvalue of B⁻¹ K, with the fingers' viscosity in B; towards low gains the rotation counts, too, whose "
      "gain "
      "stays, and bends the lines down. T has half a control period in it. A run lasts twelve delays after the nudge, "
      "and 0.6 s at least. Beyond the line `thenar check` warns.",
      kDelay,
      kGain,
      kNudge,
      [](Model& own) { own.scene.duration_s = kNudged_s + std::max(0.6, 12.0 * own.scene.control->feedback_delay_s); },
      {{"ours",
        true,
        [](const Model& own) { return run(own); },
        {limit(model, kMostDelay, "k T = π/2: swings wider beyond", count),
         limit(model, 1.0 / std::numbers::e, "k T = 1/e: overshoots beyond", count)}}},
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
