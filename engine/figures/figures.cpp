// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "engine/figures/gnuplot.h"
#include "engine/figures/grasp_picture.h"
#include "engine/results/run_events.h"
#include "thenar/palette.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

// Line styles: the fingers' colours, then those of other curves.
constexpr int kStyles = palette::kFingers.size() + palette::kOthers.size();
constexpr int kDesired = kStyles + 1, kNormal = kStyles + 2, kTangential = kStyles + 3, kAxis = kStyles + 4;

std::string line_styles() {
  std::string styles;
  int style = 0;
  const auto add = [&](const char* color, const char* look = "lw 2") {
    styles += fmt::format("set style line {} lc rgb '{}' {}\n", ++style, color, look);
  };
  for (const char* color : palette::kFingers) add(color);
  for (const char* color : palette::kOthers) add(color);
  add("#000000", "lw 1.2 dashtype '_._'");
  for (const char* color : {palette::kNormal, palette::kTangential, palette::kX, palette::kY, palette::kZ}) add(color);
  return styles;
}

std::string header(const Recording& recording, const fs::path& folder, int height) {
  return fmt::format(
      "set terminal svg size 900,{} font 'Helvetica,14' background rgb 'white'\ndata = {}\n"
      "set datafile separator comma\nset datafile columnheaders\nset datafile missing 'nan'\nset xrange [0:{}]\n"
      "set grid lc rgb '#dddddd' lt 1\nset border 3 lc rgb '#444444'\nset tics nomirror\nset key noenhanced opaque\n{}",
      height, gnuplot_string((folder / "signals.csv").string()), recording.ticks.back().time_s, line_styles());
}

/// What happened, as thin vertical lines in all panels; the words stand in the first one, which `named` ends.
struct EventMarks {
  std::string lines, named = "unset label\n";

  EventMarks(const Model& model, const Recording& recording) {
    const double end_s = recording.ticks.back().time_s;
    double free_s = 0.0;  // Words stand side by side.
    int number = 0;
    for (const auto& [time_s, what] : run_events(model.scene, recording)) {
      lines += fmt::format(
          "set arrow {0} from {1},graph 0 to {1},graph 1 nohead lw 1 lc rgb '#777777' dashtype 3\n"
          "set label {0} {2} at {3},graph 0.98 right rotate by 90 offset character 0.7,0 noenhanced front font ',11' "
          "tc "
          "rgb '#444444'\n",
          ++number, time_s, gnuplot_string(what), std::max(time_s, free_s));
      free_s = std::max(time_s, free_s) + 0.02 * end_s;
    }
  }
};

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
std::string path_script(const Model& model, const Recording& recording, const fs::path& folder) {
  const EventMarks marks(model, recording);
  const std::array<std::pair<const char*, int>, 3> axes{{{"x", kAxis}, {"y", kAxis + 1}, {"z", kAxis + 2}}};
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
  return header(recording, folder, 900) + stack(3, false) + marks.lines +
         panel(0, 3, "displacement, object axes [mm]", "[*:*]", way) + marks.named +
         panel(1, 3, "off the target, object axes [mm]", "[*:*]", off) +
         panel(2, 3, "angle to the target [deg]", "[0:*]",
               "data using 'time_s':'rotation_error_deg' with lines ls 8 notitle") +
         "unset multiplot\n";
}

/// Fig. 10: contact forces against the desired ones.
std::string forces_script(const Model& model, const Recording& recording, const fs::path& folder) {
  const EventMarks marks(model, recording);
  std::string script = header(recording, folder, 900) + stack(model.fingers(), false) + marks.lines;
  for (int k = 0; k < model.fingers(); ++k) {
    const std::string& finger = model.scene.hand.fingertips[k].finger;
    std::string curves = curve(finger + "_normal_N", "normal", kNormal) + ", " +
                         curve(finger + "_tangential_N", "tangential", kTangential);
    if (model.scene.control) {
      curves += ", " + curve(finger + "_desired_normal_N", "desired", kDesired) + ", " +
                curve(finger + "_desired_tangential_N", "", kDesired);
    }
    script += panel(k, model.fingers(), finger + ": force [N]", "[0:*]", curves) + "unset key\n" + marks.named;
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
  const EventMarks marks(model, recording);
  return header(recording, folder, 900) + stack(3, false) + marks.lines +
         panel(0, 3, "margin [-]: 0 slides as a whole", "[0:1]", margin) + "unset key\n" + marks.named +
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
  const EventMarks marks(model, recording);
  std::string script = header(recording, folder, 1000) + stack(model.fingers(), true) + marks.lines;
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
      curves += (curves.empty() ? "" : ", ") + curve(muscle.name + "_N", muscle.name, style++ % kStyles + 1);
      highest_N = std::max(highest_N, peak);
    }
    if (curves.empty()) curves = "NaN notitle";
    script += panel(k, model.fingers(), model.scene.hand.fingertips[k].finger + ": muscle force [N]",
                    fmt::format("[0:{}]", 1.15 * highest_N), curves) +
              marks.named;
  }
  return script + "unset multiplot\n";
}

/// Grip and load over the phases of a task, what is around the object bears of it, and how far it went from the table.
std::string task_script(const Model& model, const Recording& recording, const fs::path& folder) {
  const EventMarks marks(model, recording);
  std::string grip;
  for (const Fingertip& tip : model.scene.hand.fingertips)
    grip += fmt::format("{}column('{}_normal_N')", grip.empty() ? "" : " + ", tip.finger);
  const Eigen::Vector3d up = -model.scene.gravity.normalized();
  const std::string borne = fmt::format(
      "data using 'time_s':({}*column('environment_force_x_N') + {}*column('environment_force_y_N') + "
      "{}*column('environment_force_z_N')) with lines ls 3 title 'load on the environment'",
      up.x(), up.y(), up.z());
  return header(recording, folder, 760) +
         "set multiplot layout 2,1 margins 0.11,0.97,0.09,0.9 spacing 0.11\nset key at screen 0.97,0.97 right top "
         "horizontal maxrows 1\n" +
         marks.lines +
         panel(0, 2, "force [N]", "[*:*]",
               fmt::format("data using 'time_s':({}) with lines ls 1 title 'grip', ", grip) +
                   curve("borne_N", "load on the fingers", 2) + ", " + borne) +
         marks.named + "set key at screen 0.97,0.515 right top horizontal maxrows 1\n" +
         panel(1, 2, "arm, object axes at the start [mm]", "[*:*]",
               curve("arm_x_mm", "x", kAxis) + ", " + curve("arm_y_mm", "y", kAxis + 1) + ", " +
                   curve("arm_z_mm", "z", kAxis + 2)) +
         "unset multiplot\n";
}

}  // namespace

bool draw_figures(const Model& model, const Recording& recording, const State& state, const fs::path& folder) {
  return draw_figure(path_script(model, recording, folder), folder / "path.svg") &&
         draw_figure(forces_script(model, recording, folder), folder / "forces.svg") &&
         draw_figure(grip_script(model, recording, folder), folder / "grip.svg") &&
         (recording.muscle_forces_N.size() == 0 ||
          draw_figure(muscles_script(model, recording, folder), folder / "muscles.svg")) &&
         (model.scene.task.phases.empty() || draw_figure(task_script(model, recording, folder), folder / "task.svg")) &&
         draw_figure(grasp_picture_script(model, state), folder / "grasp.png");
}

}  // namespace thenar
