// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/results/recording.h"
#include "engine/results/verdict.h"

namespace thenar {

/// A setting whose margin is looked for.
struct MarginKey {
  std::string name, unit;
  double value = 0.0;  ///< The scene's.
  /// The changes to the scene for a value, as --set writes them.
  std::function<std::vector<std::string>(double)> changes;
  double most = 100.0;    ///< Ratio up to which it is tried, up and down.
  bool lockstep = false;  ///< Runs with frames from another clock.
  bool whole = false;     ///< A number of things: it takes whole values.
};

/// How far a setting may go one way.
struct Margin {
  bool up = false;
  double holds = 0.0;  ///< The last value that held; NaN if the scene itself does not.
  double fails = 0.0;  ///< The first that did not; NaN if all that was tried held.
  double ratio = 0.0;  ///< Of `holds` to the scene's, or the other way round: 1 or more; 0 if the scene does not hold.
  Verdict there;       ///< At `fails`.
};

/// The margin of a setting: the scene is run at growing ratios, and between the last that holds and the first that does
/// not the ratio is halved until it is known to `accuracy` (1.05: 5 %).
[[nodiscard]] Margin find_margin(const MarginKey& key, bool up, const std::vector<std::string>& overrides,
                                 double accuracy);

}  // namespace thenar
