#include "engine/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "engine/grasp_monitor.h"
#include "engine/summary.h"

namespace thenar {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kChatterWindow_s = 0.3;
// Steady grips have 1e-9 to 2e-4, 2e-3 in steps of 20 ms; loops and springs beyond their limits 0.014 and more.
constexpr double kChatters = 0.01;

/// Of forces that are `stride` ticks apart, over the window that ends at `until_s`.
double chatter(const std::vector<TickRecord>& ticks, std::size_t stride, double until_s) {
  double worst = kNone;
  for (std::size_t k = 0; k < kFingers; ++k) {
    const auto normal_N = [&](std::size_t i) { return ticks[i].force[k].normal_N; };
    double turns = 0.0, sum = 0.0;
    for (std::size_t i = 2 * stride; i < ticks.size() && ticks[i].time_s <= until_s; ++i) {
      if (!ticks[i].is_from(until_s - kChatterWindow_s)) continue;
      turns += 0.5 * std::abs(normal_N(i) - 2.0 * normal_N(i - stride) + normal_N(i - 2 * stride));
      sum += normal_N(i);
    }
    if (sum > 0.0) worst = std::fmax(worst, turns / sum);
  }
  return worst;
}

double chatter(const Recording& recording, double until_s) {
  std::int64_t oldest = 0;  // A loop through the controller swings with the age that frames reach.
  for (const TickRecord& tick : recording.ticks) oldest = std::max(oldest, tick.contact.frame_age);
  return std::fmax(chatter(recording.ticks, 1, until_s),
                   chatter(recording.ticks, static_cast<std::size_t>(oldest) + 1, until_s));
}

std::string joined(const std::string& first, const std::string& then) {
  return then.empty() ? first : first + "; " + then;
}

struct Slip {
  double time_s;
  std::string reason;
};

/// The first finger that slid, or carries no load though it should.
std::optional<Slip> first_slip(const Hand& hand, const std::vector<TickRecord>& ticks) {
  for (const TickRecord& tick : ticks) {
    for (int k = 0; k < kFingers; ++k) {
      const std::string& finger = hand.fingertips[k].finger;
      if (tick.slip_m[k] - tick.start_slip_m[k] > kNoticedSlip_m) {
        const double slip_m = ticks.back().slip_m[k] - ticks.back().start_slip_m[k];
        return Slip{tick.time_s, fmt::format("the {} slipped {:.2f} mm", finger, 1e3 * slip_m)};
      }
      if (tick.is_from(kLoadedFrom_s) && !(tick.force[k].normal_N > 0.0)) {
        return Slip{tick.time_s, fmt::format("the {} carried no load at {:.3f} s", finger, tick.time_s)};
      }
    }
  }
  return std::nullopt;
}

}  // namespace

const char* name(Outcome outcome) {
  switch (outcome) {
    case Outcome::kHeld:
      return "held";
    case Outcome::kSlipping:
      return "slipping";
    case Outcome::kUnstable:
      return "unstable";
    case Outcome::kOffTarget:
      return "off target";
    case Outcome::kSolverFailed:
      return "solver failed";
    case Outcome::kRefused:
      return "refused";
  }
  return "";
}

double force_chatter(const Recording& recording) {
  return recording.ticks.empty() ? kNone : chatter(recording, recording.ticks.back().time_s);
}

Verdict verdict(const Model& model, const Recording& recording) {
  const auto unsolved = solve_failure(model, recording);
  const auto& loss = recording.loss;
  const std::string lost = loss ? fmt::format("the object was lost at {:.3f} s: {}", loss->time_s, loss->reason) : "";
  if (unsolved && unsolved->contact) return {Outcome::kSolverFailed, joined(unsolved->reason, lost)};
  const auto slip = model.scene.control && !loss ? first_slip(model.scene.hand, recording.ticks) : std::nullopt;
  const std::string then = slip ? slip->reason : lost;

  // Forces of a finger that slides off are unsteady, too: what counts is how they were before.
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double lost_s = loss ? loss->since_s : slip ? slip->time_s : kNever;
  const double unsolved_s = unsolved ? unsolved->time_s : kNever;
  const double first_s = std::min(lost_s, unsolved_s);
  const double share = first_s < kNever ? chatter(recording, first_s) : force_chatter(recording);
  if (share > (first_s < kNever ? 2.0 : 1.0) * kChatters) {
    return {Outcome::kUnstable, joined(fmt::format("forces chatter by {:.0f} %", 100.0 * std::min(share, 1.0)), then)};
  }
  if (unsolved && unsolved_s <= lost_s) return {Outcome::kSolverFailed, joined(unsolved->reason, then)};
  if (loss && loss->cause == LossCause::kOffTarget) return {Outcome::kOffTarget, then};
  return {loss || slip ? Outcome::kSlipping : Outcome::kHeld, then};
}

}  // namespace thenar
