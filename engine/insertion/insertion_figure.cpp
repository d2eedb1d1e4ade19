// SPDX-License-Identifier: Apache-2.0
#include "engine/insertion/insertion_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/figures/gnuplot.h"
#include "engine/formats/files.h"
#include "engine/insertion/insertion_report.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

/// The limits of the axes.
struct Scales {
  double friction = 0.0, radius_m = 0.0;
  double play_m = 0.0;  // D - d
  double chamfer_m = 0.0;
  double deepest_m = 0.0;  // Depth of the peg's end below the plate, at least a visible one.
};

/// Contact states by their number in insertion.csv, and their style.
struct Look {
  int touch;
  const char* name;
  const char* colour;
};
constexpr std::array<Look, 6> kLooks{{{1, "plate", "#8e44ad"},
                                      {2, "chamfer", "#d68910"},
                                      {3, "one point", "#2563a8"},
                                      {4, "two points", "#c0392b"},
                                      {5, "line", "#2e8b57"},
                                      {6, "bottom", "#666666"}}};

/// Plots a column over another, by contact state.
std::string by_touch(const std::string& x, const std::string& y) {
  std::string plots;
  for (const Look& look : kLooks) {
    plots += fmt::format(
        ", data using '{}':(column('touch')=={} ? column('{}') : NaN) with points pt 7 ps 0.4 "
        "lc rgb '{}'",
        x, look.touch, y, look.colour);
  }
  return plots + fmt::format(
                     ", data using '{}':(column('wedged')==1 ? column('{}') : NaN) with points pt 6 ps 0.9 "
                     "lw 1.5 lc rgb '#000000'",
                     x, y);
}

/// Returns the legend: one line of words in the colours of all panels.
std::string legend() {
  std::string labels;
  double x = 0.075;
  const auto add = [&](const std::string& mark, const std::string& name, const char* colour) {
    labels +=
        fmt::format("set label '{} {}' at screen {},screen 0.905 left tc rgb '{}' font ',14'\n", mark, name, x, colour);
    x += 0.045 + 0.0075 * static_cast<double>(name.size());
  };
  for (const Look& look : kLooks) add("●", look.name, look.colour);
  add("○", "wedged", "#000000");
  add("—", "theory", "#000000");
  return labels;
}

/// Returns the depths below the chamfer whose parallelograms are drawn, the largest first.
std::array<double, 3> shown_depths_m(const Scales& scales) {
  const double most_m = std::max(1e-3, scales.deepest_m - scales.chamfer_m);
  return {most_m, 0.5 * most_m, 0.2 * most_m};
}

/// Draws the diagram. The peg moves on inside a parallelogram: slanted sides are two sliding points, upright ones a
/// line.
std::string diagram(const Scales& scales) {
  std::string areas;
  const double side = 1.0 / scales.friction;
  double most = 1.0;
  int object = 0;
  for (const double l_m : shown_depths_m(scales)) {
    const double lambda = l_m / (2.0 * scales.radius_m * scales.friction), top = 1.0 + 2.0 * lambda;
    const char* const colour = std::array{"#f3f3f3", "#e9e9e9", "#dcdcdc"}[object++];
    areas += fmt::format(
        "set object {0} polygon from {1},{2} to {1},1 to -{1},-{2} to -{1},-1 to {1},{2} "
        "fs solid border lc rgb '#777777' fc rgb '{3}' lw 1.2 behind\n"
        "set label '{4:.2g} mm' at {1},{2} left offset 0.6,0 tc rgb '#555555' font ',13'\n",
        object, side, top, colour, 1e3 * l_m);
    most = std::max(most, top);
  }
  return areas + fmt::format(
                     "set xrange [{0}:{1}]\nset yrange [{2}:{3}]\nset xlabel 'F_x / F_z'\nset ylabel 'M / (r F_z)'\n"
                     "set title 'the jamming diagram of three depths'\n"
                     "set label 'goes on' at 0,0 center tc rgb '#777777'\n"
                     "set label 'jams' at {4},{5} center tc rgb '#777777'\n"
                     "set label 'jams' at {6},{7} center tc rgb '#777777'\nplot NaN{8}\nunset label\nunset object\n",
                     -1.3 * side, 1.5 * side, -1.15 * most, 1.15 * most, -0.7 * side, 0.8 * most, 0.7 * side,
                     -0.8 * most, by_touch("Fx_over_Fz", "M_over_rFz"));
}

/// Draws panels over the depth, which share its axis; the theory is thin and lies above the run.
std::string over_depth(const Scales& scales) {
  const double chamfer_mm = 1e3 * scales.chamfer_m, deepest_mm = 1e3 * scales.deepest_m;
  const double wedging_mm = chamfer_mm + 2e3 * scales.friction * scales.radius_m;
  const double deg_mm = 1e3 * scales.play_m * 180.0 / std::numbers::pi;
  const auto theory = [](const char* y) {
    return fmt::format(", data using 'theory_depth_mm':'theory_{}' with points pt 7 ps 0.2 lc rgb '#000000'\n", y);
  };
  std::string script = fmt::format(
      "set bmargin at screen 0.52\nset tmargin at screen 0.82\nset xrange [{}:{}]\nset yrange [0:*]\nset xlabel ''\n"
      "set format x ''\nset ylabel 'F_z [N]'\nset title 'the push that it takes'\nplot NaN{}{}",
      std::min(-0.5, -0.04 * deepest_mm), 1.03 * deepest_mm, by_touch("depth_mm", "F_z_N"), theory("F_z_N"));
  script += fmt::format(
      "set bmargin at screen 0.11\nset tmargin at screen 0.43\nset yrange [lowest < -0.05 ? -top : 0:top]\n"
      "set xlabel 'depth of the peg''s end below the plate [mm]'\nset format x '%g'\nset ylabel 'tilt [deg]'\n"
      "set title 'its tilt; the curve: two points touch; red: friction can wedge them'\nset samples 2000\n"
      "limit(x) = x > {0} ? {1} / (x - {0}) : NaN\n"
      "plot limit(x) with lines lw 2 lc rgb '#999999', -limit(x) with lines lw 2 lc rgb '#999999', "
      "(x < {2} ? limit(x) : NaN) with lines lw 7 lc rgb '#f3b8a8', "
      "(x < {2} ? -limit(x) : NaN) with lines lw 7 lc rgb '#f3b8a8'{3}{4}",
      chamfer_mm, deg_mm, wedging_mm, by_touch("depth_mm", "tilt_deg"), theory("tilt_deg"));
  return script;
}

bool draw(const Scales& scales, const std::string& title, const fs::path& folder) {
  const std::string script = fmt::format(
      "set terminal svg size 1200,660 font 'Helvetica,15' background rgb 'white'\ndata = {}\n"
      "set datafile separator comma\nset datafile columnheaders\nset datafile missing 'nan'\n"
      "set grid lc rgb '#e6e6e6' lt 1\nset border 3 lc rgb '#444444'\nset tics nomirror\nunset key\n"
      "set title font ',15' offset 0,-0.4\nstats data using 'tilt_deg' nooutput\nlowest = STATS_min\n"
      "top = 1.25 * (STATS_max > -lowest ? STATS_max : -lowest) + 0.2\nset multiplot\n"
      "set label {} at screen 0.075,screen 0.96 left font ',18' noenhanced\n{}"
      "set lmargin at screen 0.075\nset rmargin at screen 0.47\nset bmargin at screen 0.11\nset tmargin at screen "
      "0.82\n"
      "{}unset label\nset lmargin at screen 0.57\nset rmargin at screen 0.985\n{}unset multiplot\n",
      gnuplot_string((folder / "insertion.csv").string()), gnuplot_string(title), legend(),
      scales.friction > 0.0 ? diagram(scales) : "", over_depth(scales));
  return draw_figure(script, folder / kInsertionFiles[2]);
}

}  // namespace

bool write_insertion(const Scene& scene, const InsertionStudy& study, const fs::path& folder) {
  std::error_code none;
  fs::remove(folder / kInsertionFiles[2], none);  // An earlier run's must not pass for this one's.
  write_file(folder / kInsertionFiles[0], insertion_json(scene, study).dump(2) + "\n");
  write_file(folder / kInsertionFiles[1], insertion_csv(study));
  const PegShape& peg = study.peg.shape;
  const Scales scales{peg.friction, peg.radius_m, 2.0 * (peg.hole_radius_m - peg.radius_m), peg.chamfer_m,
                      std::max(study.deepest_m(), peg.chamfer_m + 1e-3)};
  return draw(scales, scene.name + ": " + end_in_words(study), folder);
}

}  // namespace thenar
