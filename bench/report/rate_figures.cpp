// How accurate the split is, against one loop that does everything at every step, and what it costs: one table and one
// chart, error against cost. Everything runs on the virtual clock, in one thread. The reference of each scene steps and
// finds contacts every 50 us, with the control period and delay of the runs it is compared with.
//   split_accuracy_bench [--benchmark_out=FILE.json]    The chart goes beside it, as FILE.svg.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "bench/split_runs.h"
#include "engine/files.h"
#include "engine/gnuplot.h"

namespace thenar {
namespace {

namespace fs = std::filesystem;

constexpr double kReference_s = 50e-6;
constexpr double kRadian_deg = 180.0 / std::numbers::pi;

struct Result {
  std::string scene, runner;
  Timing timing;
  bool split = false, offset = false;
  Path path;
  PathError error;

  /// Wall time per simulated time: 1 is as fast as life.
  [[nodiscard]] double cost_us_per_ms() const {
    return path.wall_s / (static_cast<double>(path.X_WO.size()) * path.step_s) * 1e3;
  }
};

std::string rate(double step_s) {
  return step_s <= 1e-3 ? fmt::format("{:g} kHz", 1e-3 / step_s) : fmt::format("{:g} Hz", 1.0 / step_s);
}

// --- runs ------------------------------------------------------------------------------------------------------------

/// Without control the drive is the scene's: one loop has no other clock than its step.
std::vector<Result> run_driven(const std::string& scene, double until_s) {
  const Course course(load_scene(fs::path(THENAR_CONFIGS) / (scene + ".yaml")), {kReference_s, kReference_s}, 0.16, 0.2,
                      until_s);
  const Path reference = course.in_one_loop({kReference_s, kReference_s});
  std::vector<Result> results;
  for (const double step_s : {20e-3, 5e-3, 1e-3}) {
    const Timing timing{step_s, step_s};
    const Path path = course.in_one_loop(timing);
    results.push_back({scene, "one loop", timing, false, false, path, path_error(path, reference)});
  }
  for (const bool offset : {true, false}) {
    for (const double step_s : {1e-3, 0.25e-3}) {
      for (const double period_s : {20e-3, 5e-3}) {
        const Timing timing{step_s, period_s, period_s};
        const Path path = course.split(timing, offset);
        results.push_back({scene, "split " + rate(step_s), timing, true, offset, path, path_error(path, reference)});
      }
    }
  }
  return results;
}

/// With control, every run has the same control period and delay; what differs is the contact step.
std::vector<Result> run_controlled(const std::string& scene, double period_s, double until_s) {
  const Course course(load_scene(fs::path(THENAR_CONFIGS) / (scene + ".yaml")), {kReference_s, period_s, period_s}, 0.0,
                      0.3, until_s);
  const Path reference = course.in_one_loop({kReference_s, period_s, period_s});
  std::vector<Result> results;
  for (const double step_s : {20e-3, 1e-3, 0.25e-3}) {
    const Timing timing{step_s, period_s, period_s};
    const Path path = course.in_one_loop(timing);
    results.push_back({scene, "one loop", timing, false, false, path, path_error(path, reference)});
  }
  for (const bool offset : {true, false}) {
    for (const double step_s : {1e-3, 0.25e-3}) {
      const Timing timing{step_s, period_s, period_s};
      const Path path = course.split(timing, offset);
      results.push_back({scene, "split " + rate(step_s), timing, true, offset, path, path_error(path, reference)});
    }
  }
  return results;
}

// --- table and JSON ---------------------------------------------------------------------------------------------------

void print(const std::vector<Result>& results) {
  std::cout << fmt::format(
      "{:<10} {:<11} {:>5} {:>6} {:>6} | {:>9} {:>9} {:>8} | {:>11} {:>8} | {:>9} | {:>9}\n"
      "{:<10} {:<11} {:>5} {:>6} {:>6} | {:>9} {:>9} {:>8} | {:>11} {:>8} | {:>9} | {:>9}\n",
      "scene", "runner", "step", "frames", "offset", "position", "rotation", "force", "force step:", "", "injected/",
      "cost", "", "", "ms", "ms", "", "um rms", "mdeg rms", "mN rms", "new frame", "else mN", "dissipated",
      "us per ms");
  std::string last;
  for (const Result& r : results) {
    if (r.scene != last) std::cout << std::string(130, '-') << '\n';
    last = r.scene;
    const std::string ordinary = r.split ? fmt::format("{:.1f}", 1e3 * r.path.ordinary_step_N) : "";
    std::cout << fmt::format(
        "{:<10} {:<11} {:>5g} {:>6g} {:>6} | {:>9.3f} {:>9.3f} {:>8.3f} | {:>11.1f} {:>8} | {:>9.1e} | {:>9.1f}\n",
        r.scene, r.runner, 1e3 * r.timing.step_s, 1e3 * (r.split ? r.timing.period_s : r.timing.step_s),
        !r.split   ? ""
        : r.offset ? "on"
                   : "off",
        1e6 * r.error.position_m, 1e3 * kRadian_deg * r.error.rotation_rad, 1e3 * r.error.force_N,
        1e3 * r.path.handover_step_N, ordinary, r.path.injected_J / r.path.dissipated_J, r.cost_us_per_ms());
  }
}

nlohmann::json json(const Result& r) {
  return {{"scene", r.scene},
          {"runner", r.split ? "split" : "one_loop"},
          {"step_s", r.timing.step_s},
          {"control_period_s", r.timing.period_s},
          {"control_delay_s", r.timing.delay_s},
          {"offset", r.offset},
          {"position_rms_m", r.error.position_m},
          {"rotation_rms_rad", r.error.rotation_rad},
          {"force_rms_N", r.error.force_N},
          {"force_step_new_frame_N", r.path.handover_step_N},
          {"force_step_else_N", r.path.ordinary_step_N},
          {"injected_over_dissipated", r.path.injected_J / r.path.dissipated_J},
          {"cost_us_per_ms", r.cost_us_per_ms()}};
}

// --- chart -----------------------------------------------------------------------------------------------------------

struct Panel {
  std::string scene, title;
};

/// A runner's points in a panel, as a block of data: cost, error, point type by the frames' period, label.
std::string block(const std::string& name, const std::vector<Result>& results, const std::string& scene,
                  const std::string& runner) {
  std::string text = "$" + name + " << EOD\n";
  for (const Result& r : results) {
    if (r.scene != scene || r.runner != runner || r.split != r.offset) continue;
    const int point_type = !r.split ? 7 : r.timing.period_s > 10e-3 ? 9 : 5;
    const std::string label = r.split ? "" : fmt::format("{:g} ms", 1e3 * r.timing.step_s);
    text += fmt::format("{:.4g} {:.4g} {} \"{}\"\n", r.cost_us_per_ms(), 1e6 * r.error.position_m, point_type, label);
  }
  return text + "EOD\n";
}

/// The range of an axis that shows all values, with room for the labels beside the points.
std::string log_range(const std::vector<double>& values, double room) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return fmt::format("[{:.3g}:{:.3g}]", *least / 1.4, *most * room);
}

bool draw(const std::vector<Result>& results, const std::vector<Panel>& panels, const fs::path& file) {
  struct Curve {
    const char *runner, *title, *colour;
  };
  constexpr Curve kCurves[]{{"one loop", "one loop, at its step", "#c0392b"},
                            {"split 1 kHz", "split, contact at 1 kHz", "#2563a8"},
                            {"split 4 kHz", "split, contact at 4 kHz", "#3a8f5c"}};
  const auto is_drawn = [](const Result& r) { return r.split == r.offset; };
  std::vector<double> errors;
  for (const Result& r : results) {
    if (is_drawn(r)) errors.push_back(1e6 * r.error.position_m);
  }
  std::string script = fmt::format(
      "set terminal svg size 1500,600 font 'Helvetica,15' background rgb 'white'\nset output {}\n"
      "set multiplot layout 1,{} margins 0.06,0.985,0.12,0.81 spacing 0.025,0\n"
      "set grid lc rgb '#dddddd' lt 1\nset border 3 lc rgb '#444444'\nset tics nomirror\nset logscale xy\n"
      "set xtics (5,10,20,50,100,200,500,1000,2000,5000)\nset yrange {}\nset xlabel 'cost [µs per simulated ms]'\n"
      "set ylabel 'rms position error against a {:g} µs reference [µm]'\n"
      "set key at screen 0.52,screen 0.985 center top vertical maxrows 2 reverse Left samplen 2\n",
      gnuplot_string(file.string()), panels.size(), log_range(errors, 1.4), 1e6 * kReference_s);
  for (std::size_t p = 0; p < panels.size(); ++p) {
    std::vector<double> costs;
    for (const Result& r : results) {
      if (is_drawn(r) && r.scene == panels[p].scene) costs.push_back(r.cost_us_per_ms());
    }
    std::string plot;
    for (std::size_t c = 0; c < std::size(kCurves); ++c) {
      const auto& [runner, title, colour] = kCurves[c];
      const std::string name = fmt::format("data{}{}", p, c);
      script += block(name, results, panels[p].scene, runner);
      plot += fmt::format(
          "{0} ${1} u 1:2 w l lw 2.5 lc rgb '{2}' title '{3}', ${1} u 1:2:3 w p pt variable ps 1 lc rgb '{2}' notitle, "
          "${1} u 1:2:4 w labels left offset 0.9,0.3 tc rgb '{2}' notitle",
          c == 0 ? "plot" : ",", name, colour, title);
    }
    plot += ", NaN w p pt 9 lc rgb '#444444' title 'frames every 20 ms, 20 ms late'";
    plot += ", NaN w p pt 5 lc rgb '#444444' title 'frames every 5 ms, 5 ms late'";
    // One legend and one y axis for all panels.
    script += fmt::format("set title {}\nset xrange {}\n{}\nset key off\nset ylabel ''\nset format y ''\n",
                          gnuplot_string(panels[p].title), log_range(costs, 1.8), plot);
  }
  return run_gnuplot(script + "unset multiplot\n", file.parent_path());
}

/// Where Google Benchmark's option asks for the results.
fs::path result_file(int argc, char** argv) {
  constexpr std::string_view kOption = "--benchmark_out=";
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument.starts_with(kOption)) return argument.substr(kOption.size());
  }
  return "out/bench/split_accuracy.json";
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) try {
  using namespace thenar;
  const fs::path file = result_file(argc, argv);
  prepare_folder(file.parent_path());
  std::vector<Result> results;
  for (const auto& runs :
       {run_driven("stick", 1.0), run_driven("slide", 1.2), run_controlled("box_grasp", 20e-3, 2.5)}) {
    results.insert(results.end(), runs.begin(), runs.end());
  }
  print(results);
  nlohmann::json all = nlohmann::json::array();
  for (const Result& result : results) all.push_back(json(result));
  write_file(file, nlohmann::json{{"reference_step_s", kReference_s}, {"runs", all}}.dump(1) + "\n");
  const bool drawn = draw(results,
                          {{"stick", "carried, everything sticks"},
                           {"slide", "dragged and turned along a fingertip"},
                           {"box_grasp", "grasp, control every 20 ms, 20 ms late"}},
                          fs::path(file).replace_extension(".svg"));
  if (!drawn) std::cerr << "no chart: gnuplot is missing or failed\n";
  return 0;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
