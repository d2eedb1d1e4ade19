#include "app/exit_code.h"

#include <algorithm>
#include <array>
#include <iostream>

namespace thenar::app {

namespace {

/// In the order of Outcome.
constexpr std::array kCodes{kDone,    kDone,       kUnknown,  kOverLimits, kOffTarget, kSlipping,
                            kResting, kTaskFailed, kUnstable, kLost,       kFailed,    kBadUsage};
static_assert(kCodes.size() == kOutcomes.size());

/// Whether a code names one outcome, but for 0: held and task done.
constexpr bool are_unlike() {
  auto codes = kCodes;
  std::ranges::sort(codes);
  return std::adjacent_find(codes.begin() + 1, codes.end()) == codes.end();
}
static_assert(are_unlike());

}  // namespace

int exit_code(const Scene& scene, Outcome outcome) {
  return fails(scene, outcome) ? kCodes[static_cast<std::size_t>(outcome)] : kDone;
}

int report_verdict(const Scene& scene, const Verdict& verdict) {
  const int code = exit_code(scene, verdict.outcome);
  if (code != kDone) std::cerr << "failed: " << in_words(verdict) << '\n';
  return code;
}

}  // namespace thenar::app
