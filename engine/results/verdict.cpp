// SPDX-License-Identifier: Apache-2.0
#include "engine/results/verdict.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace thenar {

const char* to_string(Outcome outcome) {
  constexpr std::array kWords{"held",    "task done",   "unknown",  "over limits", "off target",    "slipping",
                              "resting", "task failed", "unstable", "lost",        "solver failed", "refused"};
  static_assert(kWords.size() == kOutcomes.size());
  return kWords[static_cast<std::size_t>(outcome)];
}

std::string in_words(const Excess& excess) {
  if (excess.muscle) {
    return fmt::format("the muscle {} {} {:.3g} N at {:.3f} s, {:.3g} times its {:g} N (first passed at {:.3f} s)",
                       excess.name, excess.pulled ? "pulled with" : "would need", excess.value, excess.at_s,
                       excess.value / excess.limit, excess.limit, excess.first_s);
  }
  return fmt::format("the joint {} was {:.4f} rad past its limit of {:g} rad at {:.3f} s (first passed at {:.3f} s)",
                     excess.name, std::abs(excess.value - excess.limit), excess.limit, excess.at_s, excess.first_s);
}

std::string in_words(const Verdict& verdict) {
  return verdict.reason.empty() ? to_string(verdict.outcome)
                                : fmt::format("{}: {}", to_string(verdict.outcome), verdict.reason);
}

bool fails(const Scene& scene, Outcome outcome) {
  if (is_fine(outcome)) return false;
  return scene.control || outcome == Outcome::kSolverFailed || outcome == Outcome::kUnknown ||
         outcome == Outcome::kRefused;
}

}  // namespace thenar
