// SPDX-License-Identifier: Apache-2.0
#include "engine/results/kept_rates.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "engine/loops/realtime.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

/// A percentile of a time [us], or 0 if it was not measured.
double us(const ordered_json& times, const char* percentile) {
  const ordered_json& value = times.at(percentile);
  return value.is_number() ? value.get<double>() : 0.0;
}

/// The share of the ticks that a loop did.
double kept(const ordered_json& loop) {
  const double done = loop.at("ticks").get<double>(), slipped = loop.at("slipped").get<double>();
  return done + slipped > 0.0 ? done / (done + slipped) : 1.0;
}

/// The highest rate of the series 1, 2, 5, 10, ... [Hz] whose period is not shorter than a time.
double rate_that_allows(double time_us) {
  const double most_Hz = 1e6 / time_us;
  const double decade_Hz = std::pow(10.0, std::floor(std::log10(most_Hz)));
  return decade_Hz * (most_Hz >= 5.0 * decade_Hz ? 5.0 : most_Hz >= 2.0 * decade_Hz ? 2.0 : 1.0);
}

/// What a loop's tick has to fit into its period, and what it took.
struct LoopTimes {
  double period_us;
  const ordered_json& late;  ///< From the time at which a tick was due to its start.
  const ordered_json& tick;
  [[nodiscard]] double needed_us() const { return us(late, "p99_us") + us(tick, "p99_us"); }
  [[nodiscard]] bool is_too_long() const { return us(tick, "p50_us") > period_us; }
  [[nodiscard]] bool has_long_tail() const { return us(tick, "p99_us") > period_us; }

  /// What took longer than the period.
  [[nodiscard]] std::string cause() const {
    if (is_too_long())
      return fmt::format("a tick takes {:.0f} us, and the period is {:.0f} us", us(tick, "p50_us"), period_us);
    if (has_long_tail()) {
      return fmt::format("a tick takes {:.0f} us, but one of a hundred {:.0f} us, and the period is {:.0f} us",
                         us(tick, "p50_us"), us(tick, "p99_us"), period_us);
    }
    return fmt::format(
        "a tick takes {:.0f} us of a period of {:.0f} us, but the thread started late, one of a hundred by {:.0f} us "
        "and at worst by {:.0f} us: other programs had its core (`thenar doctor` tells what this machine can keep)",
        us(tick, "p50_us"), period_us, us(late, "p99_us"), us(late, "max_us"));
  }

  /// A rate that the times allow.
  [[nodiscard]] std::string cure(const char* flag) const {
    const double rate_Hz = rate_that_allows(needed_us());
    const bool in_kHz = rate_Hz >= 1e3;
    return fmt::format("{} {:g}{} would be kept", flag, in_kHz ? rate_Hz / 1e3 : rate_Hz, in_kHz ? "kHz" : "Hz");
  }
};

/// The stage of a control tick that takes the most, and what makes it shorter.
std::string longest_stage(const ordered_json& stages) {
  struct Stage {
    const char *key, *name, *cure;
  };
  constexpr Stage kStages[] = {
      {"find", "finding contacts", ", which fewer control points (--set contact.level=1) or a smaller squeeze shorten"},
      {"factors", "the compliance of the contacts", ", which fewer control points (--set contact.level=1) shorten"},
      {"grasp_lcp", "the grasp's forces", ""},
      {"muscle_lcp", "the muscles' forces", ""}};
  const Stage* longest = &kStages[0];
  for (const Stage& stage : kStages) {
    if (us(stages.at(stage.key), "p50_us") > us(stages.at(longest->key), "p50_us")) longest = &stage;
  }
  return fmt::format("; most of it is {}, {:.0f} us{}", longest->name, us(stages.at(longest->key), "p50_us"),
                     longest->cure);
}

std::optional<std::string> contact_not_kept(const ordered_json& loop, const ordered_json& settings) {
  if (kept(loop) >= kKeptShare) return std::nullopt;
  const LoopTimes times{1e6 / settings.at("contact_rate_hz").get<double>(), loop.at("jitter"), loop.at("compute")};
  std::string sentence = fmt::format("the contact loop kept {:.0f} % of its ticks, so simulated time lagged behind: {}",
                                     100.0 * kept(loop), times.cause());
  if (times.is_too_long() && loop.at("sweeps_p50").is_number()) {
    sentence += fmt::format(
        "; it takes {:.0f} sweeps, which a larger --tolerance or fewer contacts (--set contact.level=1) shorten",
        loop.at("sweeps_p50").get<double>());
  }
  return sentence + "; " + times.cure("--contact-rate");
}

std::optional<std::string> control_not_kept(const ordered_json& loop, const ordered_json& settings) {
  if (kept(loop) >= kKeptShare) return std::nullopt;
  const LoopTimes times{1e6 / settings.at("control_rate_hz").get<double>(), loop.at("jitter"), loop.at("total")};
  std::string sentence =
      fmt::format("the control loop kept {:.0f} % of its ticks, so frames were older than they should be: {}",
                  100.0 * kept(loop), times.cause());
  if (times.is_too_long()) sentence += longest_stage(loop.at("stages"));
  return sentence + "; " + times.cure("--control-rate");
}

}  // namespace

std::vector<std::string> rates_not_kept(const ordered_json& summary) {
  const ordered_json &loops = summary.at("loops"), &settings = summary.at("settings");
  std::vector<std::string> sentences;
  for (const std::optional<std::string>& sentence :
       {contact_not_kept(loops.at("contact"), settings), control_not_kept(loops.at("control"), settings)}) {
    if (sentence) sentences.push_back(*sentence);
  }
  return sentences;
}

}  // namespace thenar
