// SPDX-License-Identifier: Apache-2.0
#include "engine/studies/savings.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/loops/percentiles.h"
#include "engine/studies/model_parts.h"

namespace thenar {

namespace {

constexpr int kFewestTurns = 6;
constexpr int kMostTurns = 15;
constexpr double kNarrow_us = 3.0, kNarrowShare = 0.05;  // Half the width of an interval that says enough.

}  // namespace

Saving saving_of(std::vector<double> differences_us) {
  std::ranges::sort(differences_us);
  const auto n = std::ssize(differences_us);
  // Values cut off at each end: the most for which a coin's n throws give so few heads, or fewer, in 2.5 % of all
  // cases. P(heads <= k) is summed from its terms n over k, divided by 2^n.
  double term = 1.0, sum = 1.0, all = 1.0;
  for (std::ptrdiff_t i = 0; i < n; ++i) all *= 2.0;
  std::ptrdiff_t cut = 0;
  for (std::ptrdiff_t k = 0; sum / all <= 0.025; ++k) {
    cut = k;
    term *= static_cast<double>(n - k) / static_cast<double>(k + 1);
    sum += term;
  }
  return {percentile(differences_us, 0.5), differences_us[cut], differences_us[n - 1 - cut]};
}

Savings measure_savings(const Model& full, const std::vector<Model>& without,
                        const std::function<void(const std::string&)>& on_run) {
  std::vector<double> full_us;
  std::vector<std::vector<double>> differences_us(without.size());
  Savings savings;
  const auto wide = [&](const Saving& saving) {
    return saving.high_us - saving.low_us > 2.0 * std::max(kNarrow_us, kNarrowShare * savings.full_us);
  };
  for (int turn = 1; turn <= kMostTurns; ++turn) {
    if (on_run) on_run(fmt::format("times, turn {} of {} to {}", turn, kFewestTurns, kMostTurns));
    full_us.push_back(run_path(full).us);
    for (std::size_t i = 0; i < without.size(); ++i) {
      differences_us[i].push_back(full_us.back() - run_path(without[i]).us);
    }
    if (turn < kFewestTurns) continue;
    savings.full_us = percentiles(full_us).p50;
    savings.turns = turn;
    savings.without.clear();
    for (const std::vector<double>& of : differences_us) savings.without.push_back(saving_of(of));
    if (std::ranges::none_of(savings.without, wide)) break;
  }
  return savings;
}

}  // namespace thenar
