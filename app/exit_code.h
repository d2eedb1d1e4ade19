// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// Returns the exit code of a run that came to an end: 0 unless it failed.
[[nodiscard]] int exit_code(const Scene& scene, Outcome outcome);

/// Returns the exit code, and prints on stderr why the run failed.
[[nodiscard]] int report_verdict(const Scene& scene, const Verdict& verdict);

/// Returns the exit code of a command that has written its results: `code`, or kInterrupted after a signal. One that
/// came after the verdict, which does not tell of it then, is told on stderr.
[[nodiscard]] int code_at_end(int code, bool was_stopped_at_verdict);

}  // namespace thenar::app
