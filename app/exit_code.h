// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/results/verdict.h"

namespace thenar::app {

/// Exit codes of the program: table in docs/guide/run.md.
enum ExitCode {
  kDone = 0,
  kInternal = 1,
  kBadUsage = 2,
  kBadFile = 3,
  kNoPort = 4,
  kFailed = 6,  ///< A solver or a phase of a task failed, or rows of a sweep are missing.
  kLost = 7,
  kSlipping = 8,
  kOffTarget = 9,
  kUnstable = 10,
  kOverLimits = 11,
  kUnknown = 12,
  kInterrupted = 130  ///< Ctrl-C or another signal, as in shells: results so far are kept.
};

/// Lines on exit codes at the end of a command's help: of most commands, of those that end as a run does, and of all.
inline constexpr const char* kCodesOfMost =
    "Exit code: 0, or 2 for a wrong command, scene or hand, 3 for a file that cannot be read or written.";
[[nodiscard]] std::string codes_of_outcomes();
inline constexpr const char* kAllCodes =
    "Exit codes: 0 if all went well, 1 for an internal error or too little memory, 2 for a wrong command, scene or "
    "hand, "
    "3 for a file that cannot be read or written, 4 for a port of the window that cannot be used, 130 if interrupted. "
    "What became of a grasp has codes from 6 on: thenar run --help.";

/// Returns the exit code of a run that came to an end: 0 unless it failed.
[[nodiscard]] int exit_code(const Scene& scene, Outcome outcome);

/// Returns the exit code, and prints on stderr why the run failed.
[[nodiscard]] int report_verdict(const Scene& scene, const Verdict& verdict);

/// Returns the exit code of a command that has written its results: `code`, or kInterrupted after a signal. One that
/// came after the verdict, which does not tell of it then, is told on stderr.
[[nodiscard]] int code_at_end(int code, bool was_stopped_at_verdict);

}  // namespace thenar::app
