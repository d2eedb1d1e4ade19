// SPDX-License-Identifier: Apache-2.0
// How a peg goes into a hole in a hand: the push against Whitney's theory, and where it jams, wedges and slips.
//   insertion_figures [--quick] FILE.json

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "bench/cases/pegs.h"
#include "bench/report/figure.h"
#include "bench/report/outcome_map.h"
#include "engine/environment/minimum_jerk.h"
#include "engine/insertion/insertion_report.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"

namespace thenar {
namespace {

using nlohmann::ordered_json;

constexpr double kPeg_m = 20e-3, kDeepest_m = 24e-3;  // Of configs/peg.yaml; below the chamfer.
constexpr double kStiff_Nm_per_rad = 4.0;
constexpr double kLimitTilt = 180.0 / std::numbers::pi;

/// The peg of configs/peg.yaml, which all runs share.
const Model& peg_model() {
  static const Model model = build_model(load_scene(std::string(THENAR_CONFIGS) + "/peg.yaml", {"object.points=9000"}));
  return model;
}

InsertionStudy study(Scene scene, bool lockstep) {
  const PegScene peg = peg_scene(scene, "configs/peg.yaml");
  RunSettings settings;
  if (lockstep) settings.lockstep = LockstepSettings{};
  return study_insertion(build_model(std::move(scene), peg_model()), peg, settings);
}

// --- the push -------------------------------------------------------------------------------------------------------

/// F_z over the depth, of a run and of the theory, at every `every`-th of their points.
ordered_json push_curves(const InsertionStudy& how) {
  constexpr std::size_t kPoints = 400;
  std::vector<double> depth_mm, push_N, theory_mm, theory_N;
  double last_mm = -1.0;
  for (const PegTick& tick : how.ticks) {
    const double mm = 1e3 * tick.depth_m;
    if (tick.touch == PegTouch::kFree || mm < last_mm + 1e3 * how.deepest_m() / kPoints) continue;
    depth_mm.push_back(last_mm = mm);
    push_N.push_back(tick.push_N);
  }
  for (const PegForce& force : how.theory) {
    if (force.points == 0) continue;
    theory_mm.push_back(1e3 * force.depth_m);
    theory_N.push_back(force.push_N);
  }
  return {plain_curve("run", depth_mm, push_N), theory_curve("theory", theory_mm, theory_N)};
}

void add_push(ordered_json& part, bool quick) {
  const double over_s = quick ? 5.0 : 20.0;
  struct Case {
    std::string name;
    PegMiss miss;
    ordered_json curves = {}, row = {};
  };
  std::vector<Case> cases = {{"0.2 mm, 1 degree", {.over_s = over_s}},
                             {"0.1 mm, 2 degrees", {.tilt_deg = 2.0, .clearance_m = 0.1e-3, .over_s = over_s}},
                             {"0.05 mm, 1 degree", {.clearance_m = 0.05e-3, .over_s = over_s}}};
  tbb::parallel_for(std::size_t{0}, cases.size(), [&](std::size_t i) {
    const InsertionStudy how = study(with_miss(peg_model().scene, cases[i].miss), false);
    cases[i].curves = push_curves(how);
    cases[i].row = {cases[i].name, end_in_words(how)};
    for (const PegTouch touch : {PegTouch::kChamfer, PegTouch::kOnePoint, PegTouch::kTwoPoints}) {
      const double off = how.off_theory(touch);
      cases[i].row.push_back(std::isnan(off) ? ordered_json("-") : ordered_json(100.0 * off));
    }
  });
  ordered_json panels = ordered_json::array(), rows = ordered_json::array();
  for (const Case& one : cases) {
    panels.push_back({{"name", one.name}, {"curves", one.curves}});
    rows.push_back(one.row);
  }
  ordered_json& curves = add_figure(
      part, "curves", "insertion_push", "The push of an insertion",
      fmt::format(
          "F_z over the depth of the peg's end below the plate, while a hole comes over a peg in {:g} s that a "
          "hand holds. The theory: a rectangle on the springs of the controller slides into a slot, chamfer, one "
          "point, two points; between the first two it slips by itself.",
          over_s),
      "One deterministic run each on a virtual clock: no times are measured.");
  curves["x"] = {{"label", "depth [mm]"}, {"log", false}};
  curves["y"] = {{"label", "F_z [N]"}, {"log", false}};
  curves["panels"] = panels;
  ordered_json& figure = add_figure(part, "table", "insertion_off_theory", "The push against the theory",
                                    "How far F_z is from the theory's at the same depth, of its largest in that phase. "
                                    "The object's damping, which the theory has not, is most of what is left.",
                                    "As above.");
  figure["columns"] = {"clearance and tilt", "what becomes of it", "off on the chamfer [%]", "off in one point [%]",
                       "off in two points [%]"};
  figure["rows"] = rows;
}

// --- maps -----------------------------------------------------------------------------------------------------------

struct MapCell {
  std::string outcome, reason = {};
};

/// The fingers' failure is named where the hole did nothing to cause it.
MapCell cell_of(const InsertionStudy& how) {
  const bool failed = how.verdict.outcome != Outcome::kHeld;
  const std::string grasp = failed ? fmt::format("; the grasp: {}", to_string(how.verdict.outcome)) : "";
  if (how.end == PegEnd::kWedged || how.end == PegEnd::kJammed) return {to_string(how.end), end_in_words(how) + grasp};
  if (failed) return {to_string(how.verdict.outcome), how.verdict.reason};
  if (how.end != PegEnd::kIn) return {to_string(how.end), end_in_words(how)};
  for (const PegPhase& phase : how.phases) {
    if (phase.touch == PegTouch::kTwoPoints) return {"two points"};
  }
  return {"free"};
}

MapCell run_cell(Scene scene, bool lockstep) {
  try {
    return cell_of(study(std::move(scene), lockstep));
  } catch (const ConfigError& error) {
    return {to_string(Outcome::kRefused), error.what()};
  }
}

struct PegPanel {
  std::string name;
  std::function<void(PegMiss&)> change = {};
  std::vector<MapLimit> limits = {};  ///< Of this panel alone.
};

/// What becomes of pegs over two settings.
struct PegMap {
  std::string id, title, caption;
  MapAxis x, y;
  std::function<Scene(PegMiss, double x, double y)> scene;
  std::vector<PegPanel> panels;
  std::vector<MapLimit> limits;
  std::optional<std::array<double, 2>> reference = {};
  bool lockstep = false;
};

void add_peg_map(ordered_json& part, const PegMap& map, int count) {
  const std::vector<double> xs = map.x.values(count), ys = map.y.values(count);
  const std::size_t cells = xs.size() * ys.size();
  std::vector<MapCell> found(map.panels.size() * cells);
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
    PegMiss miss;
    if (const auto& change = map.panels[i / cells].change) change(miss);
    const std::size_t at = i % cells;
    found[i] = run_cell(map.scene(miss, xs[at % xs.size()], ys[at / xs.size()]), map.lockstep);
  });
  ordered_json panels = ordered_json::array();
  for (std::size_t p = 0; p < map.panels.size(); ++p) {
    ordered_json rows = ordered_json::array();
    for (std::size_t y = 0; y < ys.size(); ++y) {
      rows.push_back(ordered_json::array());
      for (std::size_t x = 0; x < xs.size(); ++x) {
        const MapCell& cell = found[p * cells + y * xs.size() + x];
        rows.back().push_back({{"outcome", cell.outcome}, {"reason", cell.reason}});
      }
    }
    ordered_json lines = ordered_json::array();
    for (const auto* limits : {&map.limits, &map.panels[p].limits}) {
      for (const MapLimit& limit : *limits) lines.push_back({{"label", limit.label}, {"x", limit.x}, {"y", limit.y}});
    }
    panels.push_back({{"name", map.panels[p].name}, {"ours", true}, {"cells", rows}, {"limits", lines}});
  }
  ordered_json& figure = add_figure(part, "map", map.id, map.title, map.caption,
                                    "One deterministic run a cell on a virtual clock: no times are measured.");
  const auto axis = [](const MapAxis& of, const std::vector<double>& values) -> ordered_json {
    return {{"label", of.label}, {"values", values}, {"log", true}};
  };
  figure["x"] = axis(map.x, xs);
  figure["y"] = axis(map.y, ys);
  figure["panels"] = panels;
  figure["reference"] = map.reference ? ordered_json(*map.reference) : ordered_json(nullptr);
}

const std::vector<PegPanel> kHands = {
    {"centre at the tip"},
    {"centre at the middle", [](PegMiss& miss) { miss.tip = false; }},
    {"at the tip, rotation 8 times as stiff", [](PegMiss& miss) { miss.rotation_Nm_per_rad = kStiff_Nm_per_rad; }}};

/// A line over an axis.
MapLimit line(const std::string& label, const MapAxis& x, int count, const std::function<double(double)>& y) {
  MapLimit limit{label, {}, {}};
  for (const double at : x.values(count)) {
    limit.x.push_back(at);
    limit.y.push_back(y(at));
  }
  return limit;
}

/// Without what is beyond the axis.
MapLimit within(MapLimit limit, const MapAxis& y) {
  MapLimit kept{limit.label, {}, {}};
  for (std::size_t i = 0; i < limit.x.size(); ++i) {
    if (limit.y[i] < y.low || limit.y[i] > y.high) continue;
    kept.x.push_back(limit.x[i]);
    kept.y.push_back(limit.y[i]);
  }
  return kept;
}

PegMap clearance_tilt() {
  constexpr double kFriction = 0.2;
  const MapAxis clearance{"", "", 0.05, 0.5, "clearance D - d [mm]"}, tilt{"", "", 0.4, 6.0, "tilt [deg]"};
  const auto wedging = [=](double mm) { return kLimitTilt * 1e-3 * mm / (kPeg_m + 1e-3 * mm) / kFriction; };
  const auto two_points = [](double mm) { return kLimitTilt * 1e-3 * mm / kDeepest_m; };
  return {
      "insertion_clearance_tilt",
      "Clearance and tilt",
      "A hole comes over a peg of 20 mm that a hand holds, by 25 mm in two seconds; it is 0.5 mm aside and tilted; "
      "friction 0.2. Below the lower line one point touches all the way, if the peg keeps its tilt. Above the upper "
      "one friction can wedge it, where the hand keeps its tilt: a hand that turns easily does not.",
      clearance,
      tilt,
      [](PegMiss miss, double x, double y) {
        miss.clearance_m = 1e-3 * x;
        miss.tilt_deg = y;
        return with_miss(peg_model().scene, miss);
      },
      kHands,
      {within(line("wedging is possible above: c / μ", clearance, 40, wedging), tilt),
       within(line("two points touch above: θ l = c D at 24 mm", clearance, 40, two_points), tilt)},
      {{0.2, 1.0}}};
}

PegMap friction_depth() {
  constexpr double kPlay_m = 0.2e-3;
  const MapAxis friction{"", "", 0.05, 0.8, "friction μ"},
      depth{"", "", 2.0, 24.0, "depth l at which two points would touch [mm]"};
  return {"insertion_friction_depth",
          "Friction and depth",
          "The friction of the hole against the depth below the chamfer at which the peg, which is tilted accordingly, "
          "would touch two points: l = c D / θ, clearance 0.2 mm. Right of the line the line through both is in their "
          "friction cones.",
          friction,
          depth,
          [=](PegMiss miss, double x, double y) {
            miss.friction = x;
            miss.tilt_deg = kLimitTilt * kPlay_m / (1e-3 * y);
            return with_miss(peg_model().scene, miss);
          },
          kHands,
          {within(line("wedging is possible right of it: l = μ d", friction, 40,
                       [](double mu) { return 1e3 * mu * kPeg_m; }),
                  depth)},
          std::nullopt};
}

PegMap delay_speed() {
  constexpr double kPeriod_s = 5e-3, kWay_mm = 26.0;
  const MapAxis delay{"", "", 1.0, 50.0, "delay of the frames [ms]"},
      speed{"", "", 10.0, 250.0, "largest speed of the hole [mm/s]"};
  const Scene& peg = peg_model().scene;
  const auto at = [&](const std::string& label, double rate_per_s) {
    const double ms = 1e3 * (std::numbers::pi / 2.0 / rate_per_s - kPeriod_s);
    return MapLimit{label, {ms, ms}, {speed.low, speed.high}};
  };
  // What turns the peg about its origin, where its damping is: at the tip the place's spring does, too.
  const auto turn = [&](double lever_m) {
    const double p = peg.control->rotation.p + peg.control->position.p * lever_m * lever_m;
    return at("turns: (p_r + p L²) (T_c + delay) / b_r = π/2", p / peg.object.rotation_damping);
  };
  const MapLimit place =
      at("place: p (T_c + delay) / b_t = π/2", peg.control->position.p / peg.object.translation_damping);
  return {
      "insertion_delay_speed",
      "Delay and speed of approach",
      "How late the frames of the control loop come, every 5 ms, against how fast the hole of configs/peg.yaml comes; "
      "contact at 1 kHz. The tick finds the contacts with the hole itself, so that a late frame lets no peg through a "
      "wall. The lines are where the pose's loops, a delayed integrator each, swing by themselves; L is from the "
      "peg's middle to the centre of control.",
      delay,
      speed,
      [=](PegMiss miss, double x, double y) {
        miss.over_s = kMinimumJerkPeak * kWay_mm / y;
        Scene scene = with_miss(peg_model().scene, miss);
        scene.control_period_s = kPeriod_s;
        scene.control_delay_s = 1e-3 * x;
        return scene;
      },
      {{kHands[0].name, kHands[0].change, {turn(30e-3)}}, {kHands[1].name, kHands[1].change, {turn(0.0)}}},
      {place},
      std::nullopt,
      true};
}

void add_maps(ordered_json& part, bool quick) {
  const int count = quick ? 4 : 7;
  for (const PegMap& map : {clearance_tilt(), friction_depth(), delay_speed()}) add_peg_map(part, map, count);
}

// --- a task off its hole --------------------------------------------------------------------------------------------

/// What becomes of configs/peg_assembly.yaml whose arm stops off the hole, and the largest normal force of a finger.
std::string offset_cell(double offset_mm, double direction_deg) {
  const double rad = direction_deg / 180.0 * std::numbers::pi;
  const std::string by =
      fmt::format("[{:.4f} mm, {:.4f} mm, 0 mm]", offset_mm * std::cos(rad), 40.0 + offset_mm * std::sin(rad));
  const Model model = build_model(load_scene(std::string(THENAR_CONFIGS) + "/peg_assembly.yaml",
                                             {"task.phases[3].move.by=" + by, "object.points=9000"}));
  State state(model);
  const Recording recording = run_scene(model, state, RunSettings{});
  Ledger all;
  double most_N = 0.0;
  for (const TickRecord& tick : recording.ticks) {
    all.add(tick.contact.ledger);
    for (const NormalTangential& force : tick.force) most_N = std::max(most_N, force.normal_N);
  }
  return fmt::format("{}, {:.1f} N, {:.0e}", to_string(recording.verdict.outcome), most_N,
                     all.injected_J / all.drive_J);
}

void add_offsets(ordered_json& part, bool quick) {
  const std::vector<double> offsets_mm =
      quick ? std::vector<double>{0.5} : std::vector<double>{0.25, 0.5, 0.75, 0.9975};
  const int directions = quick ? 4 : 12;
  std::vector<std::string> cells(directions * offsets_mm.size());
  tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t i) {
    const auto direction = static_cast<double>(i / offsets_mm.size());
    cells[i] = offset_cell(offsets_mm[i % offsets_mm.size()], 360.0 / directions * direction);
  });
  ordered_json& figure = add_figure(
      part, "table", "insertion_offsets", "A task whose arm stops off the hole",
      "configs/peg_assembly.yaml, by the offset's size and its direction from +x to +y, object axes: the outcome, the "
      "largest normal force of a finger, and the share of the drive's energy that contacts gave. Chamfer and clearance "
      "take 1.05 mm. Towards -y the index moves the peg on by friction alone, and squeezes accordingly.",
      "One deterministic run a cell on a virtual clock: no times are measured.");
  ordered_json columns = {"direction [deg]"};
  for (const double mm : offsets_mm) columns.push_back(fmt::format("{:.2f} mm off", mm));
  figure["columns"] = columns;
  figure["rows"] = ordered_json::array();
  for (int d = 0; d < directions; ++d) {
    ordered_json row = {360.0 / directions * d};
    for (std::size_t k = 0; k < offsets_mm.size(); ++k) row.push_back(cells[d * offsets_mm.size() + k]);
    figure["rows"].push_back(row);
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(
      argc, argv, "insertion", "A peg in a hole",
      "Free: it goes in and touches one point at most. Two points: it goes in, held at both sides. Wedged: two "
      "contacts that stick have the line through them in both friction cones, and hold the peg between them. "
      "Jammed: it stands still in a hole that comes on, without that. Outside: it did not come below the "
      "chamfer. The other words are those of the grasp.",
      {add_push, add_maps, add_offsets});
}
