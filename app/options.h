#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/hand.h"
#include "app/record_flags.h"
#include "app/scene_flags.h"
#include "app/stiffness.h"
#include "engine/scenes/scene_file.h"

namespace thenar::app {

/// Who runs the two loops.
enum class Runner {
  kMonolithic,  ///< One loop, as the paper.
  kLockstep,    ///< Two loops on a virtual clock.
  kRealtime,    ///< Two threads.
};

/// What the command line asks for.
struct Options {
  std::string command;  ///< By its name.
  std::filesystem::path scene;
  std::vector<std::string> overrides;  ///< Of the scene, key=value, the last one wins: all flags that change it, too.
  RateFlags rates;                     ///< The overrides have them, too.
  std::filesystem::path out;           ///< Folder of results; empty: none.
  std::string format = "text";         ///< Or "json".
  bool quiet = false;
  Runner runner = Runner::kMonolithic;

  double control_jitter_s = 0.0;  ///< Of lockstep.

  // Of runs on one thread.
  std::filesystem::path dump_problems;  ///< Folder for problem files; empty: none.
  std::int64_t dump_every = 25;         ///< Ticks from one dump to the next.

  RecordFlags record;                         ///< Of what a run looks like.
  std::filesystem::path recording;            ///< That is exported,
  std::filesystem::path html, csv, npz, sto;  ///< and what to; empty: not to this.

  bool parts = false;  ///< Of check: weigh the model's parts by running the scene without them.

  // Of solve.
  std::vector<std::filesystem::path> problems;
  std::string method;               ///< Or "all"; empty: each problem's default.
  std::optional<double> tolerance;  ///< Of the residuals; nothing: each problem's default.
  int repeat = 100;                 ///< Timed solves at most.
  double solve_time_s = 1.0;        ///< For a file's.
  bool forces = false;              ///< Show them, too.
  std::filesystem::path written;    ///< File for the contact problem with its solution; empty: none.

  // Of keys.
  std::string prefix;     ///< Of those that are listed; empty: all.
  bool markdown = false;  ///< As docs/reference/scene.md.
  bool stub = false;      ///< As python/thenar/_core.pyi.
  bool measures = false;  ///< The page of measures.

  HandOptions hand;
  StiffnessOptions stiffness;

  // Of sweeps.
  std::vector<std::string> vary;  ///< As written, the last one turns fastest.
  int jobs = 0;                   ///< Rows at a time; 0: one a core, or one a process under mpirun.

  // Of grasp and new.
  std::string subject;              ///< Object's file or scene.
  std::filesystem::path object;     ///< Of a new scene.
  std::filesystem::path hand_file;  ///< Empty: the one that comes with the program.
  std::string unit, mass, press;    ///< As written; empty: m, 100 g, as much as the mass wants.
  std::optional<double> friction;
  int best = 5;

  bool figures = true;  ///< Draw the figures of a run into `out`.

  // Of the two threads.
  double spin_s = 50e-6;
  bool realtime = true;         ///< Ask for real-time scheduling.
  int core = -1;                ///< The contact thread's; -1: the last.
  bool floor = false;           ///< Measure what the machine can do at best, too.
  std::filesystem::path trace;  ///< File for the last ticks as a Chrome trace; empty: none.
};

/// Reads the command line. Nothing if there is nothing left to do: help or the version is printed, or what is wrong
/// with it, and `exit_code` is set.
[[nodiscard]] std::optional<Options> parse_options(int argc, const char* const* argv, int& exit_code);

/// The scene as the command line asks for it. Throws ConfigError.
[[nodiscard]] Scene scene_of(const Options& options);

}  // namespace thenar::app
