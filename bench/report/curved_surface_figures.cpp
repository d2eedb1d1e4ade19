// SPDX-License-Identifier: Apache-2.0
// How true friction and force are on surfaces that are curved otherwise one way than the other, that are known by
// triangles or points alone, or that are smaller than a pulp.
//   curved_surface_figures [--quick] FILE.json

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/cases/curved_files.h"
#include "bench/cases/pads.h"
#include "bench/cases/probe.h"
#include "bench/report/figure.h"
#include "bench/report/outcome_map.h"
#include "engine/results/scene_run.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using nlohmann::ordered_json;
using truth::Probe, truth::Rubbed, truth::Track;

constexpr const char* kText =
    "In full slide Coulomb's law is exact in every contact, against the surface's true normal at the deformed point: "
    "so friction tells how true normals are. One pulp of 8 mm is pressed 1 mm deep, and the object slides under it "
    "for 4 mm. What is compared is the sum of what acts against the slip over the sum along the exact normals, which "
    "the engine has no part in.";

constexpr double kFriction = 0.3;

/// The error of friction of a rod from a file, relative: along the rod, or around it.
double rod_error(const std::filesystem::path& file, Index points, double radius_m, bool around) {
  Probe probe;
  probe.shape = CloudShape{file};
  probe.points = points;
  probe.friction = kFriction;
  const Track track{-radius_m * Vector3d::UnitX(), -Vector3d::UnitX(), around ? Vector3d::UnitY() : Vector3d::UnitZ(),
                    around ? 1.0 / radius_m : 0.0};
  return std::abs(truth::slide(probe, track, 4e-3, truth::rod_surface(radius_m)).ratio() / kFriction - 1.0);
}

/// Curves over x of the worst error of several rods whose files `write` makes.
void add_error_panel(ordered_json& figure, const std::string& name, const std::vector<double>& x, double x_unit,
                     double radius_m, Index points, int seeds,
                     const std::function<void(const std::filesystem::path&, double x, int seed)>& write,
                     const std::string& extension) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() /
                                       fmt::format("thenar_curved_{}_{}", getpid(), std::hash<std::string>()(name));
  std::filesystem::create_directories(folder);
  std::vector<double> along(x.size()), around(x.size());
  tbb::parallel_for(std::size_t{0}, x.size(), [&](std::size_t i) {
    for (int seed = 1; seed <= seeds; ++seed) {
      const std::filesystem::path file = folder / fmt::format("{}_{}.{}", i, seed, extension);
      write(file, x[i], seed);
      along[i] = std::max(along[i], rod_error(file, points, radius_m, false));
      around[i] = std::max(around[i], rod_error(file, points, radius_m, true));
    }
  });
  std::filesystem::remove_all(folder);
  std::vector<double> shown;
  for (const double value : x) shown.push_back(value / x_unit);
  figure["panels"].push_back(
      {{"name", name},
       {"curves", {plain_curve("along the rod", shown, along), plain_curve("around it", shown, around)}}});
}

void files(ordered_json& part, bool quick) {
  const int count = quick ? 4 : 7, seeds = quick ? 1 : 3;
  ordered_json& chords = add_figure(
      part, "curves", "chord", "Friction on rods of triangles",
      "The error of friction over how far the triangles are off the rod in their middle. 20 000 samples are taken "
      "from them, whose normals turn from triangle to triangle but not over edges of more than 20 degrees: from there "
      "on the object is a prism. Below 1 um the error is that of the samples' spacing.",
      "deterministic");
  chords["x"] = {{"label", "chord error of the triangles [um]"}, {"log", true}};
  chords["y"] = {{"label", "error of friction, relative"}, {"log", true}};
  for (const double radius_m : {4e-3, 6e-3, 12e-3}) {
    add_error_panel(
        chords, fmt::format("R = {:g} mm", 1e3 * radius_m), equal_ratios(0.1e-6, 300e-6, count), 1e-6, radius_m, 20000,
        1, [=](const auto& file, double chord_m, int /*seed*/) { write_rod_mesh(file, radius_m, 50e-3, chord_m); },
        "obj");
  }
  ordered_json& noises = add_figure(
      part, "curves", "scan_noise", "Friction on scanned rods",
      "The error of friction over the noise of the points along their normals (its standard deviation; normals have "
      "none), the worst of three seeds. Points are 0.6 mm apart.",
      "deterministic");
  noises["x"] = {{"label", "noise of the points [um]"}, {"log", true}};
  noises["y"] = {{"label", "error of friction, relative"}, {"log", true}};
  for (const double radius_m : {4e-3, 6e-3, 12e-3}) {
    add_error_panel(
        noises, fmt::format("R = {:g} mm", 1e3 * radius_m), equal_ratios(1e-6, 200e-6, count), 1e-6, radius_m, 0, seeds,
        [=](const auto& file, double noise_m, int seed) {
          write_rod_scan(file, radius_m, 50e-3, 0.6e-3, noise_m, static_cast<std::uint64_t>(seed));
        },
        "xyz");
  }
}

/// Hertz's force of a ball against the pulp, and what the pulp bears.
void small_balls(ordered_json& part, bool quick) {
  ordered_json& figure = add_figure(
      part, "curves", "small_balls", "Balls that are smaller than a pulp",
      "The force of a ball pressed into the middle between control points of a pulp, over Hertz's, up to 3 mm deep. "
      "Hertz's theory is of paraboloids; a ball bears less as it goes deep, by Sneddon's exact solution for a rigid "
      "one in a half space (black). What goes deeper than half of its radius is told as uncertain: skin would close "
      "around it. Left of the first point a ball has touched no control point for sure.",
      "deterministic");
  figure["x"] = {{"label", "depth over the ball's radius"}, {"log", false}};
  figure["y"] = {{"label", "force over Hertz's"}, {"log", false}};
  const std::vector<double> radii_m =
      quick ? std::vector{1e-3, 4e-3} : std::vector{0.5e-3, 1e-3, 1.5e-3, 2e-3, 3e-3, 4e-3, 6e-3};
  for (const Index leaves : quick ? std::vector<Index>{320} : std::vector<Index>{320, 1280}) {
    std::vector<ordered_json> curves(radii_m.size());
    tbb::parallel_for(std::size_t{0}, radii_m.size(), [&](std::size_t i) {
      const double radius_m = radii_m[i], R = 1.0 / (1.0 / truth::kProbeRadius_m + 1.0 / radius_m);
      Probe probe;
      probe.shape = SphereShape{radius_m};
      probe.points = 6000;
      probe.leaves = leaves;
      probe.X_WO.translation() = Vector3d(truth::kProbeRadius_m + radius_m, 0.0, 0.0);
      Loop loop(truth::scene_of(probe));
      std::vector<double> depth, ratio;
      for (int step = 1; step <= 120; ++step) {
        const double depth_m = 25e-6 * step;
        TickInput input;
        input.X_WT = probe.X_WO;
        input.X_WT->translation().x() -= depth_m;
        loop.tick(input);
        if (step % 6 != 0 || depth_m > 1.5 * radius_m) continue;
        depth.push_back(depth_m / radius_m);
        ratio.push_back(loop.state.load[0].force_N.x() /
                        (4.0 / 3.0 * truth::kProbeModulus_Pa * std::sqrt(R) * std::pow(depth_m, 1.5)));
      }
      curves[i] = plain_curve(fmt::format("R = {:g} mm", 1e3 * radius_m), depth, ratio);
    });
    // A rigid ball in a half space [Sneddon 1965]: F = E* ((a^2 + R^2) artanh(a/R) - a R), d = a artanh(a/R).
    std::vector<double> depth, ratio;
    for (double c = 0.05; c < 0.85; c += 0.05) {
      const double d = c * std::atanh(c), force = (c * c + 1.0) * std::atanh(c) - c;
      depth.push_back(d);
      ratio.push_back(force / (4.0 / 3.0 * std::pow(d, 1.5)));
    }
    curves.push_back(theory_curve("Sneddon, half space", depth, ratio));
    figure["panels"].push_back({{"name", fmt::format("{} control points", leaves)}, {"curves", curves}});
  }
}

void held_rods(ordered_json& part, bool quick) {
  const auto rod = [](double radius_mm) {
    return fmt::format("{{cylinder: {{radius: {:.6g} mm, length: 80 mm}}}}", radius_mm);
  };
  const auto push = [](double push_N) { return fmt::format("[0 N, 0 N, {:.6g} N]", push_N); };
  const auto ours = [](const Model& model) {
    State state(model);
    return run_scene(model, state);
  };
  MapLimit law{"Coulomb: mu 3 P", {}, {}};
  for (const double radius_mm : {0.5, 16.0}) {
    law.x.push_back(radius_mm);
    law.y.push_back(kFriction * 6.0);
  }
  add_map(part,
          {"held_rods",
           "Rods between three fingertips",
           "Three fingertips on slides press a rod with 2 N each at a friction of 0.3, and it is pushed along itself. "
           "Normals fan out around a rod, so that pads bear more than Coulomb's mu 3 P: at 4 mm by 6 %. Thinner rods "
           "go deeper into the pulps than half of their radius, where skin would close around them: there the model "
           "has no say, which a run tells.",
           {"object.shape", "mm", 0.5, 16.0, "radius of the rod [mm]", {}, rod},
           {"task.push.force", "N", 1.0, 3.2, "push along the rod [N]", {}, push},
           {"gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]", "contact.friction=0.3", "time.duration=2.5 s",
            "task.push.from=0.7 s", "task.push.rise=0.5 s", "task.push.over=2 s"},
           {},
           {{"ours", true, ours, {law}}},
           {},
           "slides_ball"},
          quick ? 5 : 11);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  return thenar::run_part(argc, argv, "curved_surface", "Curved and small surfaces", thenar::kText,
                          {thenar::files, thenar::small_balls, thenar::held_rods});
}
