// SPDX-License-Identifier: Apache-2.0
// Where sticking ends and how exactly: creep at rest, the limits of friction, and the convergence of what patches do
// with steps, samples and control points.

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/cases/pads.h"
#include "bench/cases/patch_values.h"
#include "bench/cases/resting.h"
#include "bench/cases/scene_run.h"
#include "bench/report/figure.h"
#include "engine/scenes/scene_file.h"

namespace thenar {
namespace {

using Eigen::Vector3d;
using nlohmann::ordered_json;

// --- Creep ----------------------------------------------------------------------------------------------------------

/// The fastest that a loaded point inside its cone moves on the object, from `rest.at_rest_s` on for `duration_s`
/// [um/s].
double creep_um_per_s(const Resting& rest, double period_s, double tolerance, double duration_s) {
  Scene scene = rest.scene;
  scene.control_period_s = period_s;
  scene.contact.tolerance = tolerance;
  const Model model = build_model(std::move(scene));
  GraspRun run = as_threads_would(model);
  double most_m_per_s = 0.0;
  while (run.time_s() < rest.at_rest_s + duration_s) {
    const TickReport tick = run.tick();
    if (run.time_s() <= rest.at_rest_s) continue;
    for (const PatchReport& patch : tick.patch) most_m_per_s = std::max(most_m_per_s, patch.creep_m_per_s);
  }
  return 1e6 * most_m_per_s;
}

void creep(ordered_json& part, bool quick) {
  struct Way {
    std::string name;
    double period_s, tolerance;  ///< 0: the scene's.
  };
  const std::array ways{Way{"one loop", 1e-3, 0.0}, Way{"one loop, solved to 1e-9", 1e-3, 1e-9},
                        Way{"frames every 5 ms", 5e-3, 0.0}, Way{"frames every 20 ms", 20e-3, 0.0}};
  const double duration_s = quick ? 0.5 : 20.0;
  std::vector<Resting> scenes = resting();
  const std::filesystem::path bunny = std::filesystem::path(THENAR_CONFIGS) / "bunny.yaml";
  if (const Scene scene = load_scene(bunny); std::filesystem::exists(std::get<CloudShape>(scene.object.shape).file)) {
    scenes.insert(scenes.begin() + 2, {"bunny", scene, 3.0});
  }
  const auto count = static_cast<int>(scenes.size() * ways.size());
  std::vector<double> speeds(count);
  tbb::parallel_for(0, count, [&](int i) {
    const Resting& rest = scenes[i / ways.size()];
    const Way& way = ways[i % ways.size()];
    const double tolerance = way.tolerance > 0.0 ? way.tolerance : rest.scene.contact.tolerance;
    speeds[i] = creep_um_per_s(rest, way.period_s, tolerance, duration_s);
  });
  ordered_json& figure = add_figure(
      part, "table", "creep", "Creep of fingers that stick, at rest",
      fmt::format(
          "The fastest that any loaded point which is inside its friction cone moves along the object's surface, "
          "in any tick of {:g} s at rest [µm/s]: from the motion of bodies, pulps and soft surfaces, not from "
          "the solver. In one loop with a new frame every millisecond, at the scene's tolerance (1e-7) and at "
          "1e-9, and in two loops in lockstep with a frame every 5 and 20 ms. The hand holds mug, capsule, box "
          "and bunny; three pads with constant forces the others.",
          duration_s),
      "deterministic");
  figure["columns"] = {"object"};
  for (const Way& way : ways) figure["columns"].push_back(way.name);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    ordered_json row{scenes[i].name};
    for (std::size_t j = 0; j < ways.size(); ++j) row.push_back(fmt::format("{:.2g}", speeds[i * ways.size() + j]));
    figure["rows"].push_back(row);
  }
}

// --- Limits of friction ---------------------------------------------------------------------------------------------

/// Of pads that hold less and less as x goes from 0.7 to 1.3: where they hold no more, to 0.5 %.
double limit(const std::function<Pads(double x)>& pads) {
  double held = 0.7, lost = 1.3;
  while (lost - held > 5e-3) {
    const double middle = 0.5 * (held + lost);
    (hold(pads(middle)) ? held : lost) = middle;
  }
  return 0.5 * (held + lost);
}

/// The most that a patch slips while the grip builds up.
double slip_at_start_mm(const Pads& pads) { return 1e3 * patch_values(scene_of(pads), 0.5).row(0).maxCoeff(); }

void limits(ordered_json& part, bool quick) {
  ordered_json& figure = add_figure(
      part, "table", "limits", "What friction holds, against the laws of Coulomb and of soft fingers",
      "By bisection to 0.5 %: the least friction and the most mass with which the object falls no more once the grip "
      "has built up. Three pads of 2 N carry a ball by friction alone: Coulomb's law has mu 6 N = m g. An eccentric "
      "weight turns the object, too, and the pads carry torsion: the law is the limit load with the ellipsoid between "
      "a pad's friction and its torsion (of Hertz's pressure), from which a Hertz patch differs by up to 6 %; normals "
      "that lean within a patch take 2 %. The pinch has 2 N on either side of a box. Slip at the start: the most that "
      "a patch slips in the first 0.5 s, while the pulps give way, 5 % within the limit.",
      "deterministic");
  figure["columns"] = {"grasp", "what is looked for", "by law", "found", "found / law", "slip at the start [mm]"};
  struct Row {
    std::string grasp, what;
    double law;
    bool least;
    std::function<Pads(double x)> pads;  ///< Held less as x grows.
  };
  std::vector<Row> rows;
  for (const double radius_m : quick ? std::vector{25e-3} : std::vector{15e-3, 25e-3, 40e-3}) {
    const std::string grasp = fmt::format("ball, R = {:g} mm", 1e3 * radius_m);
    const Pads ball = pads_round(SphereShape{radius_m}, radius_m);
    const double friction = ball.mass_kg * 9.81 / 6.0;
    rows.push_back({grasp, "least friction of 100 g", friction, true, [ball, friction](double x) {
                      Pads pads = ball;
                      pads.friction = friction / x;
                      return pads;
                    }});
    rows.push_back({grasp, "most mass at 0.4 [g]", 1e3 * 0.4 * 6.0 / 9.81, false, [ball](double x) {
                      Pads pads = ball;
                      pads.friction = 0.4;
                      pads.mass_kg = x * 0.4 * 6.0 / 9.81;
                      return pads;
                    }});
  }
  const BoxShape box{Vector3d(50e-3, 50e-3, 50e-3)};
  for (const auto& [grasp, of] : {std::pair{"ball, R = 25 mm", pads_round(SphereShape{25e-3}, 25e-3)},
                                  std::pair{"pinch of a box", pads_across(box, 50e-3, 0.0)},
                                  std::pair{"pinch, pads 14 mm apart", pads_across(box, 50e-3, 14e-3)}}) {
    for (const double eccentricity_m : quick ? std::vector{20e-3} : std::vector{5e-3, 10e-3, 20e-3}) {
      Pads eccentric = of;
      eccentric.friction = 0.1;
      eccentric.depth_m = 1.6e-3;
      eccentric.centre_of_mass_m.y() = eccentricity_m;
      const double most_kg = most_mass_kg(eccentric, scene_of(eccentric).fingertips->material.reduced_modulus_Pa);
      rows.push_back({grasp, fmt::format("most mass at 0.1, {:g} mm off [g]", 1e3 * eccentricity_m), 1e3 * most_kg,
                      false, [eccentric, most_kg](double x) {
                        Pads pads = eccentric;
                        pads.mass_kg = x * most_kg;
                        return pads;
                      }});
    }
  }
  for (const Row& row : rows) {
    const double x = limit(row.pads), ratio = row.least ? 1.0 / x : x;
    figure["rows"].push_back({row.grasp, row.what, fmt::format("{:.3g}", row.law),
                              fmt::format("{:.3g}", ratio * row.law), fmt::format("{:.3f}", ratio),
                              fmt::format("{:.2f}", slip_at_start_mm(row.pads(0.95 * x)))});
  }
}

// --- Convergence ----------------------------------------------------------------------------------------------------

constexpr std::array kWhat{"slip", "spin", "margin", "patch moment"};
constexpr double kRun_s = 0.14;

/// A panel: errors of what patches do over x, against a reference.
ordered_json panel(const std::string& name, const std::vector<double>& x, const std::vector<PatchValues>& values,
                   const PatchValues& reference) {
  ordered_json curves = ordered_json::array();
  for (std::size_t i = 0; i < kWhat.size(); ++i) {
    std::vector<double> errors;
    for (const PatchValues& value : values) errors.push_back(relative_errors(value, reference)[static_cast<int>(i)]);
    curves.push_back(curve(kWhat[i], x, errors));
  }
  return {{"name", name}, {"curves", curves}};
}

void convergence(ordered_json& part, bool quick) {
  const Scene scene = turned_ball();
  const auto with_step = [&](double step_s) {
    Scene other = scene;
    other.step_s = other.control_period_s = step_s;
    return patch_values(other, kRun_s);
  };
  const auto with_samples = [&](int samples) {
    Scene other = scene;
    other.object.points = samples;
    return patch_values(other, kRun_s);
  };
  const auto with_points = [&](int points) { return patch_values(with_controls(scene, points), kRun_s); };

  const auto add = [&](const std::string& id, const std::string& title, const std::string& caption,
                       const std::string& label, const auto& x, const auto& run, const auto& finest) {
    std::vector<double> places(x.begin(), x.end());
    std::vector<PatchValues> values(x.size());
    PatchValues reference;
    tbb::parallel_for(std::size_t{0}, x.size() + 1, [&](std::size_t i) {
      (i == 0 ? reference : values[i - 1]) = i == 0 ? run(finest) : run(x[i - 1]);
    });
    ordered_json& figure = add_figure(
        part, "curves", id, title,
        caption +
            " A ball between three pads of 2 N is moved by 0.6 mm and turned by 4 degrees, friction 0.5; parts of the "
            "patches slide. Slip and spin: of all ticks together; margin and moment about the normal: at the end. "
            "Differences from the finest run over its size, all fingers together; the exponent n is the order.",
        "deterministic");
    figure["x"] = {{"label", label}, {"log", true}};
    figure["y"] = {{"label", "difference from the finest run"}, {"log", true}};
    figure["panels"].push_back(panel("ball between pads", places, values, reference));
  };
  add("convergence_step", "Convergence with the step", "Halving the step and the control period.", "step [s]",
      quick ? std::vector{4e-3, 2e-3, 1e-3} : std::vector{4e-3, 2e-3, 1e-3, 0.5e-3, 0.25e-3}, with_step,
      quick ? 0.25e-3 : 0.0625e-3);
  add("convergence_samples", "Convergence with the object's samples", "More samples on the object's surface.",
      "samples of the object", quick ? std::vector{1500, 3000, 6000} : std::vector{1500, 3000, 6000, 12000, 24000},
      with_samples, quick ? 24000 : 100000);
  add("convergence_controls", "Convergence with the fingertips' control points",
      "More control points a fingertip, with room for an eighth of them in contact, so that no list is full.",
      "control points of a fingertip", quick ? std::vector{80, 160, 320} : std::vector{80, 160, 320, 640, 1280},
      with_points, quick ? 640 : 2560);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(
      argc, argv, "motion", "Sticking and sliding",
      "How still fingers are that should stick, where friction gives way, and how what patches do converges. "
      "All is judged by the motion of bodies and pulps, by analytic limits, and by finer runs.",
      {creep, limits, convergence});
}
