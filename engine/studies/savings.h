#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/grasp/model.h"

namespace thenar {

/// What a tick takes less without something.
struct Saving {
  double us = 0.0;                     ///< Median.
  double low_us = 0.0, high_us = 0.0;  ///< Where the true median lies with 95 % or more.
};

/// The median of differences, and its interval by the sign test: no more than half of them lie on either side of the
/// true median, but for chance. Requires 6 of them or more: fewer say nothing at 95 %.
[[nodiscard]] Saving saving_of(std::vector<double> differences_us);

/// The times of scenes that are run in turns, so that all meet the same neighbours.
struct Savings {
  double full_us = 0.0;  ///< Median of the full model's ticks.
  int turns = 0;
  std::vector<Saving> without;
};

/// Runs the full model and the others in turns, until the intervals are within 3 us or 5 % of a tick, or 15 times.
/// `on_run` is called before each run, with words that say which it is.
[[nodiscard]] Savings measure_savings(const Model& full, const std::vector<Model>& without,
                                      const std::function<void(const std::string&)>& on_run = {});

}  // namespace thenar
