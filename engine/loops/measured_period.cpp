// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/measured_period.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/grasp/state.h"
#include "engine/grasp/stopwatch.h"
#include "engine/loops/percentiles.h"
#include "engine/loops/split_grasp.h"

namespace thenar {

namespace {

constexpr double kLongest_s = 5e-3;
constexpr double kUnit_s = 0.1e-3;
constexpr int kTicks = 200;

}  // namespace

double measured_control_period_s(const Model& model) {
  Model slow = model;  // The grasp runs with the longest period, which any machine keeps.
  slow.scene.control_period_s = std::max(kLongest_s, slow.scene.step_s);
  const auto steps = std::max<std::int64_t>(1, std::llround(kLongest_s / slow.scene.step_s));
  SplitGrasp grasp(slow, State(slow));
  std::vector<double> tick_s;
  for (int i = 0; i < kTicks; ++i) {
    for (std::int64_t step = 0; step < steps; ++step) grasp.contact_step();
    Stopwatch watch;
    grasp.control_step();
    tick_s.push_back(watch.lap());
  }
  const double wanted_s = kUnit_s * std::ceil(2.0 * percentiles(tick_s).p99 / kUnit_s);
  return std::max(std::min(wanted_s, kLongest_s), model.scene.step_s);
}

}  // namespace thenar
