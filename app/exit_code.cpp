#include "app/exit_code.h"

#include <iostream>

using thenar::Outcome;

int exit_code(const thenar::Scene& scene, Outcome outcome) {
  if (!fails(scene, outcome)) return kDone;
  switch (outcome) {
    case Outcome::kHeld:
      return kDone;
    case Outcome::kUnknown:
      return ::kUnknown;  // not the NaN of that name
    case Outcome::kOverLimits:
      return kOverLimits;
    case Outcome::kOffTarget:
      return kOffTarget;
    case Outcome::kSlipping:
      return kSlipping;
    case Outcome::kUnstable:
      return kUnstable;
    case Outcome::kLost:
      return kLost;
    case Outcome::kSolverFailed:
      return kFailed;
    case Outcome::kRefused:
      return kBadUsage;
  }
  return kInternal;
}

int report_verdict(const thenar::Scene& scene, const thenar::Verdict& verdict) {
  const int code = exit_code(scene, verdict.outcome);
  if (code != kDone) std::cerr << "failed: " << in_words(verdict) << '\n';
  return code;
}
