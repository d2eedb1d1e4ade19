// SPDX-License-Identifier: Apache-2.0
#include "bench/report/margins.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/report/outcome_map.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

namespace {

Verdict judge(const MarginKey& key, std::vector<std::string> changes, double value) {
  for (const std::string& change : key.changes(value)) changes.push_back(change);
  try {
    const Model model = build_model(load_scene(std::string(THENAR_CONFIGS) + "/box_grasp.yaml", changes));
    return run_and_judge(model, [&](const Model& own) {
      State state(own);
      return key.lockstep ? run_scene(own, state, {.lockstep = LockstepSettings{}}) : run_scene(own, state);
    });
  } catch (const ConfigError& error) {
    return {Outcome::kRefused, error.what()};
  }
}

}  // namespace

Margin find_margin(const MarginKey& key, bool up, const std::vector<std::string>& overrides, double accuracy) {
  constexpr double kGrowth = 2.5;
  const auto at = [&](double ratio) {
    const double value = up ? key.value * ratio : key.value / ratio;
    return key.whole ? std::round(value) : value;
  };
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  Margin margin{up, kNone, kNone, 0.0, judge(key, overrides, key.value)};
  if (margin.there.outcome != Outcome::kHeld) {
    margin.fails = key.value;
    return margin;
  }
  double holds = 1.0, fails = 1.0;
  while (fails == 1.0 && holds < key.most) {
    const double ratio = std::min(key.most, kGrowth * holds);
    margin.there = judge(key, overrides, at(ratio));
    (margin.there.outcome == Outcome::kHeld ? holds : fails) = ratio;
  }
  while (fails > accuracy * holds) {
    const double ratio = std::sqrt(holds * fails);
    if (at(ratio) == at(holds) || at(ratio) == at(fails)) break;
    const Verdict verdict = judge(key, overrides, at(ratio));
    const bool held = verdict.outcome == Outcome::kHeld;
    (held ? holds : fails) = ratio;
    if (!held) margin.there = verdict;
  }
  margin.holds = at(holds);
  margin.ratio = holds;
  if (fails > 1.0) margin.fails = at(fails);
  return margin;
}

}  // namespace thenar
