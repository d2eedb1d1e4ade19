// SPDX-License-Identifier: Apache-2.0
#include "app/exit_code.h"

#include <array>
#include <iostream>

#include "app/progress.h"

namespace thenar::app {

namespace {

/// In the order of Outcome. What rests, the hand has lost.
constexpr std::array kCodes{kDone, kDone,   kUnknown,  kOverLimits, kOffTarget, kSlipping,
                            kLost, kFailed, kUnstable, kLost,       kFailed,    kBadUsage};
static_assert(kCodes.size() == kOutcomes.size());

}  // namespace

int exit_code(const Scene& scene, Outcome outcome) {
  return fails(scene, outcome) ? kCodes[static_cast<std::size_t>(outcome)] : kDone;
}

int report_verdict(const Scene& scene, const Verdict& verdict) {
  const int code = exit_code(scene, verdict.outcome);
  if (code != kDone) std::cerr << "failed: " << in_words(verdict) << '\n';
  return code;
}

int code_at_end(int code, bool was_stopped_at_verdict) {
  if (!stop_is_asked()) return code;
  if (!was_stopped_at_verdict) std::cerr << "interrupted after the run had ended: its results are complete\n";
  return kInterrupted;
}

}  // namespace thenar::app
