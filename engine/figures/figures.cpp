// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "engine/figures/gnuplot.h"
#include "engine/figures/grasp_picture.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

std::string header(const Recording& recording, const fs::path& folder, int height) {
  return fmt::format(
      "set terminal svg size 900,{} font 'Helvetica,14' background rgb 'white'\ndata = {}\n"
      "set datafile separator comma\nset datafile columnheaders\nset datafile missing 'nan'\nset xrange [0:{}]\n"
      "set grid lc rgb '#dddddd' lt 1\nset border 3 lc rgb '#444444'\nset tics nomirror\nset key noenhanced opaque\n"
      "set style line 1 lc rgb '#c0392b' lw 2\nset style line 2 lc rgb '#2563a8' lw 2\n"
      "set style line 3 lc rgb '#3a8f5c' lw 2\nset style line 4 lc rgb '#888888' lw 2\n"
      "set style line 5 lc rgb '#8e44ad' lw 2\nset style line 6 lc rgb '#d68910' lw 2\n"
      "set style line 7 lc rgb '#17a2b8' lw 2\nset style line 8 lc rgb '#222222' lw 2\n"
      "set style line 9 lc rgb '#000000' lw 1.2 dashtype '_._'\n",
      height, gnuplot_string((folder / "signals.csv").string()), recording.ticks.back().time_s);
}

constexpr int kDesired = 9;  // The dash-dotted style.

std::string curve(const std::string& column, const std::string& title, int style) {
  return fmt::format("data using 'time_s':'{}' with lines ls {} title {}", column, style, gnuplot_string(title));
}

/// The layout of `count` panels, one above the other; the key stands over the first one or at the right.
std::string stack(int count, bool key_at_right) {
  return fmt::format("set multiplot layout {},1 margins 0.11,{},0.09,0.93 spacing 0.05\nset key {}\n", count,
                     key_at_right ? 0.86 : 0.97,
                     key_at_right ? "rmargin center vertical samplen 2" : "tmargin center horizontal");
}

/// Panel i of `count`: only the last one shows its time axis.
std::string panel(int i, int count, const std::string& y_label, const std::string& y_range, const std::string& curves) {
  const bool last = i + 1 == count;
  return fmt::format("set xlabel '{}'\nset format x '{}'\nset ylabel {} noenhanced\nset yrange {}\nplot {}\n",
                     last ? "time [s]" : "", last ? "%g" : "", gnuplot_string(y_label), y_range, curves);
}

/// Fig. 9: the object's way along its own axes against its target's, and how far it is off.
std::string path_script(const Recording& recording, const fs::path& folder) {
  const std::array<std::pair<const char*, int>, 3> axes{{{"x", 4}, {"y", 2}, {"z", 1}}};
  std::string way, off;
  for (const auto& [axis, style] : axes) {
    const char* const comma = way.empty() ? "" : ", ";
    way += comma + curve(fmt::format("position_{}_mm", axis), axis, style);
    off += fmt::format(
        "{}data using 'time_s':(column('position_{}_mm') - column('target_{}_mm')) with lines ls {} notitle", comma,
        axis, axis, style);
  }
  for (const auto& [axis, style] : axes) {
    way += ", " + curve(fmt::format("target_{}_mm", axis), axis[0] == 'x' ? "targets" : "", kDesired);
  }
  return header(recording, folder, 900) + stack(3, false) +
         panel(0, 3, "displacement, object axes [mm]", "[*:*]", way) +
         panel(1, 3, "off the target, object axes [mm]", "[*:*]", off) +
         panel(2, 3, "angle to the target [deg]", "[0:*]",
               "data using 'time_s':'rotation_error_deg' with lines ls 8 notitle") +
         "unset multiplot\n";
}

/// Fig. 10: contact forces against the desired ones.
std::string forces_script(const Model& model, const Recording& recording, const fs::path& folder) {
  std::string script = header(recording, folder, 900) + stack(model.fingers(), false);
  for (int k = 0; k < model.fingers(); ++k) {
    const std::string& finger = model.scene.hand.fingertips[k].finger;
    std::string curves =
        curve(finger + "_normal_N", "normal", 1) + ", " + curve(finger + "_tangential_N", "tangential", 2);
    if (model.scene.control) {
      curves += ", " + curve(finger + "_desired_normal_N", "desired", kDesired) + ", " +
                curve(finger + "_desired_tangential_N", "", kDesired);
    }
    script += panel(k, model.fingers(), finger + ": force [N]", "[0:*]", curves) + "unset key\n";
  }
  return script + "unset multiplot\n";
}

std::string grip_script(const Model& model, const Recording& recording, const fs::path& folder) {
  std::string margin, slip, spin;
  for (int k = 0; k < model.fingers(); ++k) {
    const std::string& finger = model.scene.hand.fingertips[k].finger;
    const char* const comma = k > 0 ? ", " : "";
    margin += comma + curve(finger + "_margin", finger, k + 1);
    slip += comma + curve(finger + "_slip_um", finger, k + 1);
    spin += comma + curve(finger + "_spin_deg", finger, k + 1);
  }
  return header(recording, folder, 900) + stack(3, false) +
         panel(0, 3, "margin [-]: 0 slides as a whole", "[0:1]", margin) + "unset key\n" +
         panel(1, 3, "slip since first contact [um]", "[0:*]", slip) +
         panel(2, 3, "spin since first contact [deg]", "[0:*]", spin) + "unset multiplot\n";
}

/// The largest force of a muscle once the fingers have met the object.
double peak_N(const Recording& recording, Eigen::Index muscle) {
  constexpr double kFirstTouch_s = 0.05;
  double peak = 0.0;
  for (std::size_t i = 0; i < recording.ticks.size(); ++i) {
    if (recording.ticks[i].is_from(kFirstTouch_s)) peak = std::max(peak, recording.muscle_forces_N(muscle, i));
  }
  return peak;
}

/// The muscles at work. A muscle belongs to the first finger that it crosses.
std::string muscles_script(const Model& model, const Recording& recording, const fs::path& folder) {
  constexpr double kAtWork_N = 0.01;
  std::string script = header(recording, folder, 1000) + stack(model.fingers(), true);
  for (int k = 0; k < model.fingers(); ++k) {
    std::string curves;
    double highest_N = 1.0;
    int style = 0;
    for (std::size_t m = 0; m < model.scene.hand.muscles.size(); ++m) {
      const Muscle& muscle = model.scene.hand.muscles[m];
      const double peak = peak_N(recording, static_cast<Eigen::Index>(m));
      if (!model.scene.hand.fingertips[k].has_joint(model.scene.hand.leader(muscle.crossings.front().joints.front())) ||
          peak < kAtWork_N)
        continue;
      curves += (curves.empty() ? "" : ", ") + curve(muscle.name + "_N", muscle.name, style++ % 8 + 1);
      highest_N = std::max(highest_N, peak);
    }
    if (curves.empty()) curves = "NaN notitle";
    script += panel(k, model.fingers(), model.scene.hand.fingertips[k].finger + ": muscle force [N]",
                    fmt::format("[0:{}]", 1.15 * highest_N), curves);
  }
  return script + "unset multiplot\n";
}

/// Grip and load over the phases of a task, what is around the object bears of it, and how far it went from the table.
std::string task_script(const Model& model, const Recording& recording, const fs::path& folder) {
  std::string grip, phases;
  for (const Fingertip& tip : model.scene.hand.fingertips)
    grip += fmt::format("{}column('{}_normal_N')", grip.empty() ? "" : " + ", tip.finger);
  int arrow = 1;
  double left_s = 0.0;
  for (std::size_t i = 0; i < recording.ticks.size(); ++i) {
    const TickRecord& tick = recording.ticks[i];
    const bool ends = i + 1 == recording.ticks.size() || recording.ticks[i + 1].phase != tick.phase;
    if (!ends) continue;
    phases += fmt::format("set arrow {} from {}, graph 0 to {}, graph 1 nohead lc rgb '#999999' dashtype 2\n", arrow,
                          tick.time_s, tick.time_s);
    if (tick.phase < std::ssize(model.scene.task.phases)) {
      const Phase& phase = model.scene.task.phases[static_cast<std::size_t>(tick.phase)];
      phases += fmt::format("set label {} '{}' at {}, graph 0.96 center front font ',12' tc rgb '#555555'\n", arrow,
                            to_string(phase.kind), 0.5 * (left_s + tick.time_s));
    }
    left_s = tick.time_s;
    ++arrow;
  }
  const Eigen::Vector3d up = -model.scene.gravity.normalized();
  const std::string borne = fmt::format(
      "data using 'time_s':({}*column('environment_force_x_N') + {}*column('environment_force_y_N') + "
      "{}*column('environment_force_z_N')) with lines ls 4 title 'load on the environment'",
      up.x(), up.y(), up.z());
  return header(recording, folder, 760) +
         "set multiplot layout 2,1 margins 0.11,0.97,0.09,0.9 spacing 0.11\nset key at screen 0.97,0.97 right top "
         "horizontal maxrows 1\n" +
         phases +
         panel(0, 2, "force [N]", "[*:*]",
               fmt::format("data using 'time_s':({}) with lines ls 1 title 'grip', ", grip) +
                   curve("borne_N", "load on the fingers", 2) + ", " + borne) +
         "unset label\nset key at screen 0.97,0.515 right top horizontal maxrows 1\n" +
         panel(1, 2, "arm, object axes at the start [mm]", "[*:*]",
               curve("arm_x_mm", "x", 4) + ", " + curve("arm_y_mm", "y", 2) + ", " + curve("arm_z_mm", "z", 1)) +
         "unset multiplot\n";
}

}  // namespace

bool draw_figures(const Model& model, const Recording& recording, const State& state, const fs::path& folder) {
  return draw_figure(path_script(recording, folder), folder / "path.svg") &&
         draw_figure(forces_script(model, recording, folder), folder / "forces.svg") &&
         draw_figure(grip_script(model, recording, folder), folder / "grip.svg") &&
         (recording.muscle_forces_N.size() == 0 ||
          draw_figure(muscles_script(model, recording, folder), folder / "muscles.svg")) &&
         (model.scene.task.phases.empty() || draw_figure(task_script(model, recording, folder), folder / "task.svg")) &&
         draw_figure(grasp_picture_script(model, state), folder / "grasp.png");
}

}  // namespace thenar
