#include "engine/figures.h"

#include <cstdio>
#include <array>
#include <string>
#include <utility>

#include "engine/grasp_picture.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

/// Feeds a script to gnuplot; false if that failed.
bool gnuplot(const std::string& script) {
  // A missing program is an answer of the shell's, whose words would only confuse.
  std::FILE* pipe = popen("gnuplot 2>/dev/null", "w");
  if (pipe == nullptr) return false;
  const bool fed = std::fwrite(script.data(), 1, script.size(), pipe) == script.size();
  return pclose(pipe) == 0 && fed;
}

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

std::string header(const fs::path& folder, const std::string& figure, int width, int height) {
  return "set terminal svg size " + std::to_string(width) + "," + std::to_string(height) +
         " font 'Helvetica,14' background rgb 'white'\n"
         "set output " + quoted((folder / figure).string()) + "\n"
         "data = " + quoted((folder / "signals.csv").string()) + "\n"
         "set datafile separator comma\nset datafile columnheaders\nset datafile missing 'nan'\n"
         "set grid lc rgb '#dddddd' lt 1\nset border 3 lc rgb '#444444'\nset tics nomirror\nset key noenhanced\n"
         "set style line 1 lc rgb '#c0392b' lw 2\nset style line 2 lc rgb '#2563a8' lw 2\n"
         "set style line 3 lc rgb '#3a8f5c' lw 2\nset style line 4 lc rgb '#888888' lw 2\n";
}

std::string curve(const std::string& column, const std::string& title, int style, bool desired = false) {
  return "data using 'time_s':'" + column + "' with lines ls " + std::to_string(style) +
         (desired ? " dashtype '_._'" : "") + " title " + quoted(title);
}

/// Fig. 9: the object's way along its own axes against its target's.
std::string path_script(const fs::path& folder) {
  std::string script = header(folder, "path.svg", 900, 480) +
                       "set xlabel 'time [s]'\nset ylabel 'displacement of the object [mm]'\nset key left top\nplot ";
  const std::array<std::pair<const char*, int>, 3> axes{{{"x", 4}, {"y", 2}, {"z", 1}}};
  for (const auto& [axis, style] : axes) {
    const std::string name = axis;
    script += curve("position_" + name + "_mm", name, style) + ", " +
              curve("target_" + name + "_mm", name + ", target", style, true) + (name == "z" ? "\n" : ", ");
  }
  return script;
}

/// A panel a finger, one above the other.
template <typename Panel>
std::string panels(const Model& model, Panel panel) {
  std::string script = "set multiplot layout " + std::to_string(kFingers) + ",1 margins 0.09,0.97,0.08,0.96 spacing 0.06\n";
  for (int k = 0; k < kFingers; ++k) {
    const bool last = k + 1 == kFingers;
    script += std::string(last ? "set xlabel 'time [s]'\nset format x '%g'\n" : "set xlabel ''\nset format x ''\n") +
              "set label 1 " + quoted(model.scene.hand.fingertips[k].finger) + " at graph 0.01,0.93 font ',15'\n" + panel(k);
  }
  return script + "unset multiplot\n";
}

/// Fig. 10: contact forces against the desired ones.
std::string forces_script(const Model& model, const fs::path& folder) {
  return header(folder, "forces.svg", 900, 900) + "set ylabel 'force [N]'\nset yrange [0:*]\nset key right top horizontal\n" +
         panels(model, [&](int k) {
           const std::string finger = model.scene.hand.fingertips[k].finger + "_";
           std::string plot = "plot " + curve(finger + "normal_N", "normal", 1) + ", " +
                              curve(finger + "tangential_N", "tangential", 2);
           if (model.scene.control) {
             plot += ", " + curve(finger + "desired_normal_N", "normal, desired", 1, true) + ", " +
                     curve(finger + "desired_tangential_N", "tangential, desired", 2, true);
           }
           return plot + "\n";
         });
}

std::string grip_script(const Model& model, const fs::path& folder) {
  std::string script = header(folder, "grip.svg", 900, 700) +
                       "set multiplot layout 2,1 margins 0.1,0.97,0.1,0.96 spacing 0.1\nset key right top horizontal\n";
  const std::array<std::pair<const char*, const char*>, 2> parts{
      {{"cone_margin", "cone margin 1 - |F_t| / (mu F_n)"}, {"slip_mm", "slip [mm]"}}};
  for (const auto& [column, label] : parts) {
    script += "set ylabel " + quoted(label) + " noenhanced\nset yrange [" + (column[0] == 'c' ? "*<0:1" : "0:*") + "]\n" +
              (column[0] == 's' ? "set xlabel 'time [s]'\nset key left top\n" : "") + "plot ";
    for (int k = 0; k < kFingers; ++k) {
      const std::string& finger = model.scene.hand.fingertips[k].finger;
      script += curve(finger + "_" + column, finger, k + 1) + (k + 1 < kFingers ? ", " : "\n");
    }
  }
  return script + "unset multiplot\n";
}

/// A muscle belongs to the first finger that it crosses.
std::string muscles_script(const Model& model, const fs::path& folder) {
  return header(folder, "muscles.svg", 900, 1000) +
         "set ylabel 'force [N]'\nset yrange [0:*]\nset key right top outside vertical\n" + panels(model, [&](int k) {
           std::string plot;
           int color = 0;
           for (const Muscle& muscle : model.scene.hand.muscles) {
             if (muscle.crossings.front().joints.front() / kJointsPerFinger != k) continue;
             // Eight colours, then the same ones dashed.
             const std::string dash = color >= 8 ? "2" : "1";
             plot += (plot.empty() ? "plot " : ", ") + std::string("data using 'time_s':'") + muscle.name +
                     "_N' with lines lw 2 lt " + std::to_string(color % 8 + 1) + " dashtype " + dash + " title " +
                     quoted(muscle.name);
             ++color;
           }
           return plot + "\n";
         });
}

}  // namespace

bool draw_figures(const Model& model, const Recording& recording, const State& state, const fs::path& folder) {
  std::string script = path_script(folder) + "reset\n" + forces_script(model, folder) + "reset\n" + grip_script(model, folder);
  if (recording.muscle_forces_N.size() > 0) script += "reset\n" + muscles_script(model, folder);
  return gnuplot(script) && gnuplot(grasp_picture_script(model, state, folder / "grasp.png"));
}

}  // namespace thenar
