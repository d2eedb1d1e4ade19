#include "engine/verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/summary.h"

namespace thenar {

namespace {

constexpr double kChatterWindow_s = 0.3;
constexpr double kChatters = 0.05;

}  // namespace

const char* name(Outcome outcome) {
  switch (outcome) {
    case Outcome::kHeld:
      return "held";
    case Outcome::kSlipping:
      return "slipping";
    case Outcome::kUnstable:
      return "unstable";
    case Outcome::kSolverFailed:
      return "solver failed";
    case Outcome::kRefused:
      return "refused";
  }
  return "";
}

double force_chatter(const Recording& recording) {
  const auto& ticks = recording.ticks;
  double worst = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < kFingers; ++k) {
    double squares = 0.0, sum = 0.0, count = 0.0;
    for (std::size_t i = 2; i < ticks.size(); ++i) {
      if (!ticks[i].is_from(ticks.back().time_s - kChatterWindow_s)) continue;
      const double turn_N =
          ticks[i].force[k].normal_N - 2.0 * ticks[i - 1].force[k].normal_N + ticks[i - 2].force[k].normal_N;
      squares += 0.25 * turn_N * turn_N;
      sum += ticks[i].force[k].normal_N;
      ++count;
    }
    if (sum > 0.0) worst = std::fmax(worst, std::sqrt(squares * count) / sum);
  }
  return worst;
}

Verdict verdict(const Model& model, const Recording& recording) {
  if (const auto why = failure(model, recording)) {
    if (!recording.loss) return {Outcome::kSolverFailed, *why};
    const bool slipped = recording.loss->reason.find("slipped") != std::string::npos;
    return {slipped ? Outcome::kSlipping : Outcome::kUnstable, *why};
  }
  if (force_chatter(recording) > kChatters) return {Outcome::kUnstable, "the forces chatter"};
  return {Outcome::kHeld, ""};
}

}  // namespace thenar
