// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/profile_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <utility>

#include "engine/figures/gnuplot.h"
#include "engine/loops/percentiles.h"
#include "thenar/palette.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

static_assert(palette::kFingers.size() == kMaxFingers);
constexpr const char* kFrameColour = "#d68910";
constexpr const char* kSnapshotColour = "#8497a9";

std::string header(int width, int height) {
  return fmt::format(
      "set terminal svg size {},{} font 'Helvetica,15' background rgb 'white'\n"
      "set grid lc rgb '#dddddd' lt 1\nset border 3 lc rgb '#444444'\nset tics nomirror\nset key noenhanced opaque\n",
      width, height);
}

// --- distributions ---------------------------------------------------------------------------------------------------

/// The share of the sample at or above x, as a block of data, at some hundred ranks that lie evenly on a log axis.
std::string distribution(const std::string& name, std::vector<double> values) {
  constexpr double kLeast_us = 0.01;  // A log axis has no zero; no clock tells less.
  constexpr double kNextRank = 0.98;
  std::sort(values.begin(), values.end());
  std::string block = "$" + name + " << EOD\n";
  const double count = static_cast<double>(values.size());
  for (double above = count; above >= 1.0;) {
    const double x = values[values.size() - static_cast<std::size_t>(above)];
    block += fmt::format("{:.4g} {:.4g}\n", std::max(x, kLeast_us), std::floor(above) / count);
    above = std::min(above - 1.0, above * kNextRank);
  }
  return block + "EOD\n";
}

std::string jitter_script(const Model& model, const LoopProfile& profile, const JitterFloor& floor, double spin_us) {
  const auto& ticks = profile.contact();
  std::string script = header(1200, 560);
  script += distribution("jitter", collect(ticks, &ContactTrace::jitter_us));
  const std::vector<double> compute_us = collect(ticks, &ContactTrace::compute_us);
  const double longest_us = *std::max_element(compute_us.begin(), compute_us.end());
  script += distribution("compute", compute_us);
  std::string curves =
      fmt::format("$jitter with lines lw 3 lc rgb '#2563a8' title 'contact loop, {:g} µs spin'", spin_us);
  if (!floor.contact_us.empty()) {
    script += distribution("no_spin", floor.contact_us);
    curves += ", $no_spin with lines lw 3 lc rgb '#c0392b' title 'contact loop, no spin'";
  }
  if (!floor.cyclictest_us.empty()) {
    script += distribution("floor", floor.cyclictest_us);
    curves += ", $floor with lines lw 3 lc rgb '#444444' dt '-' title 'cyclictest'";
  }
  const double step_us = 1e6 * model.scene.step_s;
  // The largest value of the longest sample is the least share.
  const std::size_t most = std::max({ticks.size(), floor.contact_us.size(), floor.cyclictest_us.size()});
  script += fmt::format(
      "set multiplot layout 1,2 margins 0.08,0.98,0.13,0.89 spacing 0.09\nset logscale xy\nset format y '10^{{%T}}'\n"
      "set yrange [{:.3g}:1.2]\nset key at screen 0.53,screen 0.98 center top vertical maxrows 1 Left reverse\n"
      "set ylabel 'share of ticks at or above'\nset xlabel 'start of a tick after its deadline [µs]'\nplot {}\n"
      "set ylabel ''\nset xlabel 'computation of a tick [µs]'\n"
      "set xrange [1:{:.6g}]\nset arrow from {},graph 0 to {},graph 1 nohead lw 2 lc rgb '#888888' dt '-'\n"
      "set label 'period' at {},graph 0.97 right offset -0.7,0 tc rgb '#666666'\n"
      "plot $compute with lines lw 3 lc rgb '#2563a8' notitle\n"
      "unset multiplot\n",
      0.5 / static_cast<double>(most), curves, std::max(2.0 * step_us, 1.2 * longest_us), step_us, step_us, step_us);
  return script;
}

// --- hand-over -------------------------------------------------------------------------------------------------------

/// The middle of what the task does, or of the run.
double middle_s(const Model& model, const LoopProfile& profile) {
  const double end_s = static_cast<double>(profile.contact().back().tick) * model.scene.step_s;
  const TaskSettings& task = model.scene.task;
  double middle = 0.5 * end_s;
  if (task.push) middle = task.push->from_s + 0.5 * task.push->over_s;
  if (task.rotate) middle = task.rotate->from_s + 0.5 * task.rotate->over_s;
  if (task.translate) middle = task.translate->from_s + 0.5 * task.translate->over_s;
  return middle < end_s ? middle : 0.5 * end_s;
}

std::string handover_script(const Model& model, const LoopProfile& profile) {
  constexpr double kHalfWindow_s = 0.05;
  const double centre_s = middle_s(model, profile);
  std::string forces = "$forces << EOD\n", kicks = "$kicks << EOD\n", marks;
  PerFinger<bool> loaded(model.fingers());
  for (const ContactTrace& tick : profile.contact()) {
    const double time_s = static_cast<double>(tick.tick) * model.scene.step_s;
    if (std::abs(time_s - centre_s) > kHalfWindow_s) continue;
    const double time_ms = 1e3 * time_s;
    forces += fmt::format("{:.4f}", time_ms);
    for (int k = 0; k < model.fingers(); ++k) {
      forces += fmt::format(" {:.6g}", tick.force_N[k]);
      loaded[k] = loaded[k] || tick.force_N[k] > 0.0F;
    }
    forces += "\n";
    if (!tick.handed_over) continue;
    kicks += fmt::format("{:.4f} {:.4g}\n", time_ms, 1e3 * static_cast<double>(tick.force_step_N));
    marks +=
        fmt::format("set arrow from {0:.4f},graph 0 to {0:.4f},graph 1 nohead back lw 1 lc rgb '#bbbbbb'\n", time_ms);
  }
  if (marks.empty()) kicks += "NaN NaN\n";  // gnuplot refuses an empty block
  // A finger without load has no panel.
  const auto panels = 1 + std::count(loaded.begin(), loaded.end(), true);
  const int height = 150 + 200 * static_cast<int>(panels);
  // One legend, above the panels: the first one's, whatever it draws.
  std::string legend =
      ", NaN with lines lw 1 lc rgb '#bbbbbb' title 'hand-over', NaN with lines lw 3 lc rgb '#888888' title 'tick', "
      "NaN with lines lw 3 lc rgb '#d68910' title 'tick with a new frame'";
  std::string script = header(1100, height) + forces + "EOD\n" + kicks + "EOD\n" + marks +
                       fmt::format(
                           "set multiplot layout {},1 margins 0.1,0.97,{:.4f},{:.4f} spacing 0.04\n"
                           "set xrange [{}:{}]\nunset grid\nset grid y lc rgb '#dddddd' lt 1\n"
                           "set key at screen 0.97,screen {:.4f} right top vertical maxrows 1 Left reverse\n"
                           "set format x ''\nset format y '%.3f'\n",
                           panels, 70.0 / height, 1.0 - 75.0 / height, 1e3 * (centre_s - kHalfWindow_s),
                           1e3 * (centre_s + kHalfWindow_s), 1.0 - 36.0 / height);
  if (model.scene.control) {
    script += fmt::format(
        "set label 'The force step of a tick with a new frame includes the controller''s new torques.' "
        "at screen 0.97,screen {:.4f} right tc rgb '#444444'\n",
        1.0 - 22.0 / height);
  }
  for (int k = 0; k < model.fingers(); ++k) {
    if (!loaded[k]) continue;
    script += fmt::format(
        "set ylabel {} noenhanced\nplot $forces using 1:{} with steps lw 2 lc rgb '{}' notitle{}\nunset label\n",
        gnuplot_string(model.scene.hand.fingertips[k].finger + ": force [N]"), k + 2, palette::kFingers[k],
        std::exchange(legend, ""));
  }
  return script +
         "set format x '%g'\nset format y '%g'\nset xlabel 'time [ms]'\nset ylabel 'force step of a tick [mN]'\n"
         "set yrange [0:*]\nplot $forces using 1:5 with impulses lw 1.5 lc rgb '#888888' notitle, "
         "$kicks with impulses lw 3 lc rgb '#d68910' notitle" +
         legend + "\nunset multiplot\n";
}

// --- timeline --------------------------------------------------------------------------------------------------------

/// Bars of both loops over a window, and arrows from who published to who took. Contact stands at y = 0, control at 1.
class Timeline {
 public:
  Timeline(std::int64_t from_ns, double length_ms) : from_ns_(from_ns), length_ms_(length_ms) {}

  [[nodiscard]] double ms(std::int64_t time_ns) const { return 1e-6 * static_cast<double>(time_ns - from_ns_); }
  [[nodiscard]] bool shows(double time_ms) const { return time_ms >= 0.0 && time_ms <= length_ms_; }

  void bar(int kind, double y, double from_ms, double to_ms) {
    if (!shows(from_ms)) return;
    bars_[kind] += fmt::format("{:.5f} {} {:.5f} {:.5f} {} {}\n", from_ms, y, from_ms, std::min(to_ms, length_ms_),
                               y - kHalf, y + kHalf);
  }
  void arrow(double from_ms, double from_y, double to_ms, double to_y, const char* colour) {
    if (!shows(from_ms) || !shows(to_ms)) return;
    const double gap = from_y < to_y ? kHalf : -kHalf;
    arrows_ += fmt::format("set arrow from {:.5f},{} to {:.5f},{} size screen 0.008,18 filled lw 1.6 lc rgb '{}'\n",
                           from_ms, from_y + gap, to_ms, to_y - gap, colour);
  }

  /// Kinds of bars: contact tick, contact tick with a new frame, and the stages of a control tick, the rest of it
  /// first.
  static constexpr std::array<std::pair<const char*, const char*>, 7> kKinds{{{"contact tick", "#2563a8"},
                                                                              {"with a new frame", kFrameColour},
                                                                              {"control tick", "#c8ccd0"},
                                                                              {"grasp forces", "#8e44ad"},
                                                                              {"muscle forces", "#c0392b"},
                                                                              {"contact finding", "#3a8f5c"},
                                                                              {"compliance", "#17a2b8"}}};

  [[nodiscard]] std::string script() const {
    std::string data, plots;
    for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
      if (bars_[kind].empty()) continue;
      data += fmt::format("$bars{} << EOD\n{}EOD\n", kind, bars_[kind]);
      plots += fmt::format("{}$bars{} with boxxyerror fs solid 1.0 noborder lc rgb '{}' title '{}'",
                           plots.empty() ? "" : ", ", kind, kKinds[kind].second, kKinds[kind].first);
    }
    plots += plots.empty() ? "" : ", ";
    plots +=
        fmt::format("NaN with lines lw 2 lc rgb '{}' title 'snapshot', NaN with lines lw 2 lc rgb '{}' title 'frame'",
                    kSnapshotColour, kFrameColour);
    return header(1200, 430) + data + arrows_ +
           fmt::format(
               "unset grid\nset border 1\nset xrange [0:{}]\nset yrange [-0.45:1.45]\nset xlabel 'time [ms]'\n"
               "set ytics ('contact' 0, 'control' 1) scale 0\nset lmargin 9\nset rmargin 3\n"
               "set key tmargin center horizontal samplen 1.5 maxcols 5\n"
               "plot {}\n",
               length_ms_, plots);
  }

 private:
  static constexpr double kHalf = 0.22;  // Of a bar's height.
  std::int64_t from_ns_;
  double length_ms_;
  std::array<std::string, kKinds.size()> bars_;
  std::string arrows_;
};

void add_control(const ControlTrace& tick, Timeline& timeline) {
  const double from_ms = timeline.ms(tick.start_ns);
  timeline.bar(2, 1.0, from_ms, timeline.ms(tick.end_ns));
  double stage_ms = from_ms;
  int kind = 3;
  for (const float us : {tick.grasp_us, tick.muscle_us, tick.find_us, tick.factors_us}) {
    const double length_ms = 1e-3 * static_cast<double>(us);
    if (us > 0.0F) timeline.bar(kind, 1.0, stage_ms, stage_ms + length_ms);
    stage_ms += length_ms;
    ++kind;
  }
}

std::string timeline_script(const Model& model, const LoopProfile& profile) {
  const auto& ticks = profile.contact();
  const double length_ms = 1e3 * std::max(1.3 * model.scene.control_period_s, 8.0 * model.scene.step_s);
  // From shortly before a control tick in the middle of the run on.
  const std::int64_t middle_ns = ticks[ticks.size() / 2].start_ns;
  const auto first = std::find_if(profile.control().begin(), profile.control().end(),
                                  [&](const ControlTrace& tick) { return tick.start_ns >= middle_ns; });
  const auto lead_ns = static_cast<std::int64_t>(1e6 * 0.08 * length_ms);
  Timeline timeline((first == profile.control().end() ? middle_ns : first->start_ns) - lead_ns, length_ms);

  std::unordered_map<std::int64_t, double> frame_ms, snapshot_ms;
  for (const ControlTrace& tick : profile.control()) {
    if (!timeline.shows(timeline.ms(tick.start_ns))) continue;
    add_control(tick, timeline);
    if (tick.published) frame_ms[tick.sequence] = timeline.ms(tick.end_ns);
  }
  for (const ContactTrace& tick : ticks) {
    const double start_ms = timeline.ms(tick.start_ns), end_ms = timeline.ms(tick.end_ns);
    if (!timeline.shows(start_ms)) continue;
    timeline.bar(tick.handed_over ? 1 : 0, 0.0, start_ms, end_ms);
    snapshot_ms[tick.tick] = end_ms;
    const auto frame = frame_ms.find(tick.sequence);
    if (tick.handed_over && frame != frame_ms.end()) timeline.arrow(frame->second, 1.0, start_ms, 0.0, kFrameColour);
  }
  for (const ControlTrace& tick : profile.control()) {
    const auto snapshot = snapshot_ms.find(tick.snapshot_tick);
    if (snapshot == snapshot_ms.end()) continue;
    timeline.arrow(snapshot->second, 0.0, timeline.ms(tick.start_ns), 1.0, kSnapshotColour);
  }
  return timeline.script();
}

}  // namespace

bool draw_profile(const Model& model, const LoopProfile& profile, const JitterFloor& floor, double spin_us,
                  const fs::path& folder) {
  if (profile.contact().empty()) return false;
  return draw_figure(jitter_script(model, profile, floor, spin_us), folder / "jitter.svg") &&
         draw_figure(handover_script(model, profile), folder / "handover.svg") &&
         draw_figure(timeline_script(model, profile), folder / "timeline.svg");
}

}  // namespace thenar
