// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/grasp/model.h"

namespace thenar {

/// The time that a tick saves without a part.
struct Saving {
  double us = 0.0;                     ///< Median.
  double low_us = 0.0, high_us = 0.0;  ///< Interval of the true median with 95 % confidence or more.
};

/// Computes the median of differences, and its interval by the sign test: apart from chance, at most half of them lie
/// on either side of the true median. Requires 6 of them or more: fewer give no interval at 95 %.
[[nodiscard]] Saving saving_of(std::vector<double> differences_us);

/// The times of scenes that are run in turns, so that all meet the same load of the machine.
struct Savings {
  double full_us = 0.0;  ///< Median of the full model's ticks.
  int turns = 0;
  std::vector<Saving> without;
};

/// Runs the full model and the others in turns, until the intervals are within 3 us or 5 % of a tick, or 15 times.
/// `on_run` is called before each run, with its description.
[[nodiscard]] Savings measure_savings(const Model& full, const std::vector<Model>& without,
                                      const std::function<void(const std::string&)>& on_run = {});

}  // namespace thenar
