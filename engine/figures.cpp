#include "engine/figures.h"

#include <array>
#include <string>
#include <utility>

#include "engine/gnuplot.h"
#include "engine/grasp_picture.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

std::string header(const fs::path& folder, const std::string& figure, int width, int height) {
  return "set terminal svg size " + std::to_string(width) + "," + std::to_string(height) +
         " font 'Helvetica,14' background rgb 'white'\n"
         "set output " +
         gnuplot_string((folder / figure).string()) +
         "\n"
         "data = " +
         gnuplot_string((folder / "signals.csv").string()) +
         "\n"
         "set datafile separator comma\nset datafile columnheaders\nset datafile missing 'nan'\n"
         "set grid lc rgb '#dddddd' lt 1\nset border 3 lc rgb '#444444'\nset tics nomirror\nset key noenhanced\n"
         "set style line 1 lc rgb '#c0392b' lw 2\nset style line 2 lc rgb '#2563a8' lw 2\n"
         "set style line 3 lc rgb '#3a8f5c' lw 2\nset style line 4 lc rgb '#888888' lw 2\n";
}

std::string curve(const std::string& column, const std::string& title, int style, bool desired = false) {
  return "data using 'time_s':'" + column + "' with lines ls " + std::to_string(style) +
         (desired ? " dashtype '_._'" : "") + " title " + gnuplot_string(title);
}

/// The layout of `count` panels, one above the other, each with its own y label.
std::string stack(int count, double right) {
  return "set multiplot layout " + std::to_string(count) + ",1 margins 0.11," + std::to_string(right) +
         ",0.09,0.94 spacing 0.05\n";
}

/// What distinguishes panel i of `count`: only the last one shows its time axis.
std::string panel(int i, int count, const std::string& y_label, const std::string& plot) {
  const bool last = i + 1 == count;
  return std::string(last ? "set xlabel 'time [s]'\nset format x '%g'\n" : "set xlabel ''\nset format x ''\n") +
         "set ylabel " + gnuplot_string(y_label) + " noenhanced\nplot " + plot + "\n";
}

/// Fig. 9: the object's way along its own axes against its target's, and how far it is off.
std::string path_script(const fs::path& folder) {
  const std::array<std::pair<std::string, int>, 3> axes{{{"x", 4}, {"y", 2}, {"z", 1}}};
  std::string way, off;
  for (const auto& [axis, style] : axes) {
    const std::string comma = way.empty() ? "" : ", ";
    way += comma + curve("position_" + axis + "_mm", axis, style) + ", " +
           curve("target_" + axis + "_mm", axis + ", target", style, true);
    off += comma + "data using 'time_s':(column('position_" + axis + "_mm') - column('target_" + axis +
           "_mm')) with lines ls " + std::to_string(style) + " title " + gnuplot_string(axis);
  }
  return header(folder, "path.svg", 900, 700) + stack(2, 0.97) + "set key tmargin center horizontal\n" +
         panel(0, 2, "displacement, object axes [mm]", way) + "unset key\n" +
         panel(1, 2, "error against the target [mm]", off) + "unset multiplot\n";
}

/// Fig. 10: contact forces against the desired ones.
std::string forces_script(const Model& model, const fs::path& folder) {
  std::string script = header(folder, "forces.svg", 900, 900) + stack(kFingers, 0.97) +
                       "set yrange [0:*]\nset key tmargin center horizontal\n";
  for (int k = 0; k < kFingers; ++k) {
    const std::string& finger = model.scene.hand.fingertips[k].finger;
    std::string plot =
        curve(finger + "_normal_N", "normal", 1) + ", " + curve(finger + "_tangential_N", "tangential", 2);
    if (model.scene.control) {
      plot += ", " + curve(finger + "_desired_normal_N", "normal, desired", 1, true) + ", " +
              curve(finger + "_desired_tangential_N", "tangential, desired", 2, true);
    }
    script += panel(k, kFingers, finger + ": force [N]", plot) + "unset key\n";
  }
  return script + "unset multiplot\n";
}

std::string grip_script(const Model& model, const fs::path& folder) {
  std::string margin, slip;
  for (int k = 0; k < kFingers; ++k) {
    const std::string& finger = model.scene.hand.fingertips[k].finger;
    const std::string comma = k > 0 ? ", " : "";
    margin += comma + curve(finger + "_cone_margin", finger, k + 1);
    slip += comma + curve(finger + "_slip_um", finger, k + 1);
  }
  return header(folder, "grip.svg", 900, 700) + stack(2, 0.97) +
         "set key tmargin center horizontal\nset yrange [*<0:1]\n" +
         panel(0, 2, "cone margin, 1 - |F_t| / (mu F_n)", margin) + "unset key\nset yrange [0:*]\n" +
         panel(1, 2, "slip, counted anew from 0.3 s on [um]", slip) + "unset multiplot\n";
}

/// A muscle belongs to the first finger that it crosses.
std::string muscles_script(const Model& model, const fs::path& folder) {
  std::string script = header(folder, "muscles.svg", 900, 1000) + stack(kFingers, 0.86) +
                       "set yrange [0:*]\nset key rmargin center vertical samplen 2\n";
  for (int k = 0; k < kFingers; ++k) {
    std::string plot;
    int color = 0;
    for (const Muscle& muscle : model.scene.hand.muscles) {
      if (muscle.crossings.front().joints.front() / kJointsPerFinger != k) continue;
      plot += (plot.empty() ? "" : ", ") + std::string("data using 'time_s':'") + muscle.name +
              "_N' with lines lw 2 lt " + std::to_string(++color) + " title " + gnuplot_string(muscle.name);
    }
    if (!plot.empty()) script += panel(k, kFingers, model.scene.hand.fingertips[k].finger + ": muscle force [N]", plot);
  }
  return script + "unset multiplot\n";
}

}  // namespace

bool draw_figures(const Model& model, const Recording& recording, const State& state, const fs::path& folder) {
  std::string script =
      path_script(folder) + "reset\n" + forces_script(model, folder) + "reset\n" + grip_script(model, folder);
  if (recording.muscle_forces_N.size() > 0) script += "reset\n" + muscles_script(model, folder);
  return run_gnuplot(script, folder) && run_gnuplot(grasp_picture_script(model, state, folder / "grasp.png"), folder);
}

}  // namespace thenar
