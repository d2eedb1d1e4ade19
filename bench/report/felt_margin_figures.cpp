// SPDX-License-Identifier: Apache-2.0
// The margin that a grip keeps over a friction that it is not told, and the slip until it has found it.
//   felt_margin_figures [--quick] FILE.json

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "bench/report/figure.h"
#include "bench/report/touch_runs.h"
#include "engine/results/verdict.h"

namespace thenar {
namespace {

using nlohmann::ordered_json;

/// What a grip comes to that is not told the friction.
struct Kept {
  double margin = kNone;  ///< mu N / T - 1 of the finger with the least, a mean over the last 0.2 s.
  double slip_mm = kNone;
};

Kept kept(double friction, double margin, double noise_percent) {
  Texts changes = {fmt::format("contact.friction={:g}", friction), fmt::format("control.grasp.margin={:g}", margin)};
  if (noise_percent > 0.0) changes.push_back(fmt::format("fingertips.touch.noise={:g} %", noise_percent));
  const Recording recording = run("unknown_friction", changes);
  if (recording.verdict.outcome == Outcome::kLost) return {};
  const double from_s = recording.ticks.back().time_s - 0.2;
  Kept kept{0.0, slip_mm(recording)};
  int ticks = 0;
  for (const TickRecord& tick : recording.ticks) {
    if (tick.time_s < from_s) continue;
    double least = std::numeric_limits<double>::infinity();
    for (const NormalTangential& f : tick.force) least = std::min(least, friction * f.normal_N / f.tangential_N - 1.0);
    kept.margin += least;
    ++ticks;
  }
  kept.margin /= ticks;
  return kept;
}

constexpr std::array kMargins = {0.02, 0.1, 0.3};
constexpr std::array kNoises = {0.0, 5.0};

using AllKept = std::array<std::array<std::vector<Kept>, kMargins.size()>, kNoises.size()>;

std::vector<double> numbers_of(const std::vector<Kept>& all, double Kept::*number) {
  std::vector<double> numbers;
  for (const Kept& kept : all) numbers.push_back(kept.*number);
  return numbers;
}

ordered_json margin_panels(const std::vector<double>& frictions, const AllKept& all, double Kept::*number) {
  const std::vector<double> ends = {frictions.front(), frictions.back()};
  ordered_json panels = ordered_json::array();
  for (std::size_t n = 0; n < kNoises.size(); ++n) {
    ordered_json curves = ordered_json::array();
    for (std::size_t m = 0; m < kMargins.size(); ++m) {
      curves.push_back(plain_curve(fmt::format("margin: {:g}", kMargins[m]), frictions, numbers_of(all[n][m], number)));
      if (number == &Kept::margin) {
        curves.push_back(theory_curve("asked for", ends, {kMargins[m], kMargins[m]}));
      }
    }
    if (number == &Kept::slip_mm) {
      const double slipping_mm = 1e3 * kSlipping_m;
      curves.push_back(theory_curve("counts as slipping", ends, {slipping_mm, slipping_mm}));
    }
    panels.push_back({{"name", kNoises[n] > 0.0 ? fmt::format("{:g} % of noise in what is felt", kNoises[n])
                                                : std::string("without noise")},
                      {"curves", curves}});
  }
  return panels;
}

/// How far margins lie off what is asked for, at a noise: "0.01 to 0.04 above 0.3".
std::string margins_in_words(const AllKept& all, std::size_t noise) {
  std::string words;
  for (std::size_t m = 0; m < kMargins.size(); ++m) {
    const std::vector<double> margins = numbers_of(all[noise][m], &Kept::margin);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    int lost = 0;
    for (const double margin : margins) {
      lost += std::isnan(margin) ? 1 : 0;
      if (!std::isnan(margin)) low = std::min(low, margin), high = std::max(high, margin);
    }
    words += fmt::format("{}{:.2f} to {:.2f} for {:g}", words.empty() ? "" : ", ", low, high, kMargins[m]);
    if (lost > 0) words += fmt::format(" ({} of {} lost)", lost, margins.size());
  }
  return words;
}

void margins(ordered_json& part, bool quick) {
  std::vector<double> frictions;
  for (double mu = 0.2; mu < 1.25; mu += quick ? 0.25 : 0.1) frictions.push_back(mu);
  AllKept all;
  for (auto& of_noise : all) of_noise.fill(std::vector<Kept>(frictions.size()));
  tbb::parallel_for(std::size_t{0}, kNoises.size() * kMargins.size() * frictions.size(), [&](std::size_t job) {
    const std::size_t i = job % frictions.size(), m = job / frictions.size() % kMargins.size();
    const std::size_t n = job / frictions.size() / kMargins.size();
    all[n][m][i] = kept(frictions[i], kMargins[m], kNoises[n]);
  });
  const auto worst_mm = [&](std::size_t noise) {
    double most = 0.0;
    for (const auto& of_margin : all[noise]) {
      for (const Kept& kept : of_margin) most = std::max(most, std::isnan(kept.slip_mm) ? 0.0 : kept.slip_mm);
    }
    return most;
  };
  add_run_curves(
      part, "felt_margin", "The margin that is kept over a friction that is not told",
      fmt::format("unknown_friction: the hand expects a friction of 0.5, meets another, and eases its grip until it "
                  "feels it. Shown is the true margin, μ N / T - 1, of the finger with the least, as a mean over "
                  "the last 0.2 s of 2.5 s, for three values of control.grasp.margin. Without noise it is {}; "
                  "with {:g} % of noise at each contact {}. A fall of what is felt is believed at once, a rise slowly: "
                  "so noise makes the grip firmer.",
                  margins_in_words(all, 0), kNoises[1], margins_in_words(all, 1)),
      "friction μ", "margin μ N / T - 1", margin_panels(frictions, all, &Kept::margin));
  add_run_curves(
      part, "felt_margin_slip", "Slip while the friction is found",
      fmt::format("The most that a finger of the same runs slips after the first 0.3 s: up to {:.3g} mm without "
                  "noise, {:.3g} mm with it. {:g} mm count as slipping.",
                  worst_mm(0), worst_mm(1), 1e3 * kSlipping_m),
      "friction μ", "slip [mm]", margin_panels(frictions, all, &Kept::slip_mm));
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "felt_margin", "A friction that is not told",
                  "With `control.grasp.friction: felt` the hand takes friction from its skin: it eases its grip until "
                  "rims slip, and keeps a margin over what it feels there.",
                  {margins});
}
