#pragma once

#include "engine/results/verdict.h"

namespace thenar::app {

/// What the program ends with: docs/guide/run.md has the table.
enum ExitCode {
  kDone = 0,
  kInternal = 1,
  kBadUsage = 2,
  kBadFile = 3,
  kNoPort = 4,
  kFailed = 6,  ///< A solver or a phase of a task failed; of a sweep, rows are missing.
  kLost = 7,
  kSlipping = 8,
  kOffTarget = 9,
  kUnstable = 10,
  kOverLimits = 11,
  kUnknown = 12,
  kInterrupted = 130  ///< By Ctrl-C or another signal, as shells have it: what was done until then is kept.
};

/// Of a run that came to an end: 0 unless it failed.
[[nodiscard]] int exit_code(const Scene& scene, Outcome outcome);

/// The same, and says on stderr why it failed.
[[nodiscard]] int report_verdict(const Scene& scene, const Verdict& verdict);

}  // namespace thenar::app
