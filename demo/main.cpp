#include <unistd.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "demo/check.h"
#include "demo/table.h"
#include "engine/build_info.h"
#include "engine/config.h"
#include "engine/figures.h"
#include "engine/files.h"
#include "engine/monolithic.h"
#include "engine/signals.h"
#include "engine/summary.h"

namespace {

using namespace thenar;
namespace fs = std::filesystem;

enum ExitCode { kDone = 0, kInternal = 1, kBadUsage = 2, kBadFile = 3, kFailed = 6 };

struct Options {
  fs::path scene;
  std::vector<std::string> overrides;
  fs::path out;
  std::string format = "text";
  bool quiet = false;
};

/// Whether this machine has the instructions that the build uses.
bool host_can_run() {
#if defined(__x86_64__) && defined(__AVX2__)
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
#else
  return true;
#endif
}

/// A line on stderr that tells how far the run is, if somebody is looking.
Progress progress_line(const Scene& scene, bool quiet) {
  if (quiet || isatty(STDERR_FILENO) == 0) return {};
  return [duration_s = scene.duration_s, shown_s = 0.0](double simulated_s, double wall_s) mutable {
    if (wall_s - shown_s < 0.1 && simulated_s < duration_s) return;
    shown_s = wall_s;
    std::fprintf(stderr, "\r%.2f of %.2f s simulated, %.1f times real time ", simulated_s, duration_s,
                 simulated_s / wall_s);
  };
}

void remove_figures(const fs::path& folder) {
  std::error_code none;  // A figure that cannot be removed cannot be drawn either, and then there is a warning.
  for (const char* figure : kFigures) fs::remove(folder / figure, none);
}

void write_results(const Model& model, const Recording& recording, const State& state, const std::string& summary,
                   const fs::path& folder) {
  write_file(folder / "summary.json", summary);
  write_file(folder / "signals.csv", signals_csv(model, recording));
  // Figures of an earlier run must not pass for this one's.
  remove_figures(folder);
  if (!recording.ticks.empty() && !draw_figures(model, recording, state, folder)) {
    remove_figures(folder);
    std::cerr << "warning: no figures, for gnuplot is missing or failed\n";
  }
}

int run(const Options& options) {
  const Model model(load_scene(options.scene, options.overrides));
  if (!options.out.empty()) prepare_folder(options.out);
  State state(model);
  const Progress progress = progress_line(model.scene, options.quiet);
  const Recording recording = run_monolithic(model, state, progress);
  if (progress) std::cerr << '\n';

  const nlohmann::ordered_json summary = summarize(model, recording);
  if (!options.out.empty()) write_results(model, recording, state, summary.dump(2) + "\n", options.out);
  if (options.format == "json") {
    std::cout << summary.dump(2) << '\n';
  } else if (!options.quiet) {
    std::cout << results_table(summary);
    if (!options.out.empty()) std::cout << "\nresults in " << options.out.string() << '\n';
  }
  const std::optional<std::string> why = failure(model, recording);
  if (why) std::cerr << "failed: " << *why << '\n';
  return why ? kFailed : kDone;
}

/// A bare number, without a unit.
bool is_number(const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  return std::from_chars(text.data(), end, value).ptr == end;
}

int check(const Options& options) {
  std::cout << description(load_scene(options.scene, options.overrides));
  return kDone;
}

}  // namespace

int main(int argc, char** argv) try {
  if (!host_can_run()) {
    std::cerr
        << "error: this build is for x86-64-v3 (AVX2 and FMA); configure with -DTHENAR_ARCH=x86-64 for this machine\n";
    return kInternal;
  }
  CLI::App app{"Real-time human grasp: three deformable fingertips, 23 muscles"};
  app.set_version_flag("--version", std::string("thenar ") + std::string(build_info::kVersion));
  app.require_subcommand(1);
  Options options;
  std::string duration;

  CLI::App* run_command = app.add_subcommand("run", "Runs a scene and prints what came of it");
  CLI::App* check_command =
      app.add_subcommand("check", "Says what a scene will model, what it leaves out, and the defaults");
  for (CLI::App* command : {run_command, check_command}) {
    command->add_option("SCENE", options.scene, "Scene file (YAML)")->required();
    command->add_option("--set", options.overrides, "Changes a value: key.path=value, as often as needed")
        ->take_all()
        ->type_name("KEY=VALUE");
  }
  run_command->add_option("--out", options.out, "Folder for summary.json, signals.csv and figures")->type_name("DIR");
  run_command->add_option("--time", duration, "Simulated time in seconds, or with a unit, such as '500 ms'")
      ->type_name("T");
  run_command->add_option("--format", options.format, "What to print")->check(CLI::IsMember({"text", "json"}));
  run_command->add_flag("--quiet", options.quiet, "Prints nothing but errors (and JSON, if asked for)");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kBadUsage;
  }
  if (!duration.empty()) options.overrides.push_back("time.duration=" + duration + (is_number(duration) ? " s" : ""));
  return run_command->parsed() ? run(options) : check(options);
} catch (const ConfigError& error) {
  std::cerr << error.what() << '\n';
  return kBadUsage;
} catch (const FileError& error) {
  std::cerr << error.what() << '\n';
  return kBadFile;
} catch (const std::exception& error) {
  std::cerr << "internal error: " << error.what() << '\n';
  return kInternal;
}
