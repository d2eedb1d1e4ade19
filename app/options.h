// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/export_flags.h"
#include "app/hand_flags.h"
#include "app/record_flags.h"
#include "app/scene_flags.h"
#include "app/stiffness_flags.h"
#include "app/window_flags.h"
#include "engine/scenes/scene_file.h"

namespace CLI {
class App;
}

namespace thenar::app {

/// Execution mode of the two loops.
enum class Runner {
  kMonolithic,  ///< One loop, as in the paper.
  kLockstep,    ///< Two loops on a virtual clock.
  kRealtime,    ///< Two threads.
};

/// Settings from the command line.
struct Options {
  std::string command;  ///< Command name.
  std::filesystem::path scene;
  std::vector<std::string> overrides;  ///< Scene changes, key=value, the last one wins; with those of all flags.
  RateFlags rates;                     ///< Also in the overrides.
  std::filesystem::path out;           ///< Result folder; empty: none.
  std::string format = "text";         ///< "text" or "json".
  bool quiet = false;
  Runner runner = Runner::kMonolithic;

  double control_jitter_s = 0.0;  ///< Jitter in lockstep.

  // Runs on one thread.
  std::filesystem::path dump_problems;  ///< Folder for problem files; empty: none.
  std::int64_t dump_every = 25;         ///< Ticks from one dump to the next.

  RecordFlags record;  ///< Recording of the run.
  ExportFlags exported;

  bool parts = false;  ///< For check: weigh the model's parts by running the scene without them.

  // Options of solve.
  std::vector<std::filesystem::path> problems;
  std::string method;               ///< Method name or "all"; empty: each problem's default.
  std::optional<double> tolerance;  ///< Residual tolerance; nothing: each problem's default.
  int repeat = 100;                 ///< Largest number of timed solves.
  double solve_time_s = 1.0;        ///< Time for a file's timed solves.
  bool forces = false;              ///< Show the forces, too.
  std::filesystem::path written;    ///< File for the contact problem with its solution; empty: none.

  // Options of keys.
  std::string prefix;     ///< Prefix of the listed keys; empty: all.
  bool markdown = false;  ///< Print docs/reference/scene.md.
  bool stub = false;      ///< Print python/thenar/_core.pyi.
  bool measures = false;  ///< Print the page of measures.

  HandOptions hand;
  StiffnessOptions stiffness;
  WindowFlags window;

  bool browser = true;  ///< For docs: open them on a desktop.

  // Options of sweep.
  std::vector<std::string> vary;  ///< Variations as written; the last one turns fastest.
  int jobs = 0;                   ///< Rows at a time; 0: one a core, or one a process under mpirun.

  // Options of grasp and new.
  std::string subject;              ///< Object's file or scene.
  std::filesystem::path object;     ///< Object of a new scene.
  std::filesystem::path hand_file;  ///< Empty: the one that comes with the program.
  std::string unit, mass, press;    ///< As written; empty: m, 100 g, as much as the mass wants.
  std::optional<double> friction;
  int best = 5;

  bool figures = true;  ///< Draw the figures of a run into `out`.

  // Options of the two threads.
  double spin_s = 50e-6;
  bool realtime = true;         ///< Ask for real-time scheduling.
  int core = -1;                ///< The contact thread's; -1: the last.
  bool floor = false;           ///< Also measure the machine's least jitter.
  std::filesystem::path trace;  ///< File for the last ticks as a Chrome trace; empty: none.
};

/// Shows the description of the command line to `use`.
void with_command_line(const std::function<void(const CLI::App&)>& use);

/// Reads the command line. Returns nothing if nothing is left to do: help, the version or an error is printed, and
/// `exit_code` is set.
[[nodiscard]] std::optional<Options> parse_options(int argc, const char* const* argv, int& exit_code);

/// Returns the scene with the changes of the command line. Throws ConfigError.
[[nodiscard]] Scene scene_of(const Options& options);

}  // namespace thenar::app
