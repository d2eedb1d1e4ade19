// SPDX-License-Identifier: Apache-2.0
#include "app/exit_code.h"

#include <fmt/format.h>

#include <array>
#include <iostream>
#include <map>

#include "app/progress.h"

namespace thenar::app {

namespace {

/// In the order of Outcome. What rests, the hand has lost.
constexpr std::array kCodes{kDone, kDone,   kUnknown,  kOverLimits, kOffTarget, kSlipping,
                            kLost, kFailed, kUnstable, kLost,       kFailed,    kBadUsage};
static_assert(kCodes.size() == kOutcomes.size());

}  // namespace

std::string codes_of_outcomes() {
  std::map<int, std::string> words;
  for (const Outcome outcome : kOutcomes) {
    std::string& word = words[kCodes[static_cast<std::size_t>(outcome)]];
    word += (word.empty() ? "" : " or ") + std::string(to_string(outcome));
  }
  words.erase(kBadUsage);
  std::string text = fmt::format("Exit code: {} for {}", kDone, words.extract(kDone).mapped());
  text +=
      ", and where nothing controls the grasp; 2 for a wrong command, scene or hand, 3 for a file that cannot be read "
      "or written";
  for (const auto& [code, word] : words) text += fmt::format(", {} for {}", code, word);
  return text + fmt::format(", {} if interrupted.", static_cast<int>(kInterrupted));
}

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
