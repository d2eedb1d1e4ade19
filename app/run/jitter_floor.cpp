// SPDX-License-Identifier: Apache-2.0
#include "app/run/jitter_floor.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "app/run/cyclictest.h"
#include "engine/loops/percentiles.h"
#include "engine/loops/threads.h"
#include "engine/results/profile.h"

namespace thenar::app {

namespace {

constexpr int kPairs = 5;
constexpr double kPair_s = 2.0;  // Of each run, or the scene's duration if that is less.

void append(std::vector<double>& all, const std::vector<double>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

MeasuredFloor measure_floor(const Model& model, ThreadSettings settings) {
  if (std::system("command -v cyclictest >/dev/null 2>&1") != 0) {
    std::cerr << "warning: no floor, for cyclictest is missing: apt-get install rt-tests\n";
    return {};
  }
  settings.duration_s = std::min(kPair_s, model.scene.duration_s);
  settings.spin_s = 0.0;
  const std::int64_t loops = std::llround(settings.duration_s / model.scene.step_s);
  MeasuredFloor floor;
  std::vector<double> theirs_us, ours_us, ratios;
  std::string remark;
  for (int pair = 0; pair < kPairs; ++pair) {
    // A grasp that is lost ends no pair: both are to have as many ticks.
    State state(model);
    LoopProfile profile;
    settings.on_tick = [&](const ContactSample& sample) {
      profile.add(sample);
      return true;
    };
    const ThreadsReport report = run_threads(model, state, settings);
    const Scheduling& granted = report.contact;
    const auto cyclictest_us = run_cyclictest(granted, model.scene.step_s, loops);
    if (!cyclictest_us) {
      std::cerr << "warning: no floor, for cyclictest was refused what the contact thread was granted\n";
      return {};
    }
    // Without SCHED_FIFO ours asks for short turns, see ask_for_realtime, which cyclictest cannot be told to.
    if (settings.realtime && granted.policy != "SCHED_FIFO") {
      remark = "cyclictest had no short turns, which the contact thread asks for where SCHED_FIFO is refused";
    }
    const std::vector<double> jitter_us = collect(profile.contact(), &ContactTrace::jitter_us);
    theirs_us.push_back(percentiles(*cyclictest_us).p99);
    ours_us.push_back(percentiles(jitter_us).p99);
    ratios.push_back(ours_us.back() / theirs_us.back());
    append(floor.jitter.cyclictest_us, *cyclictest_us);
    append(floor.jitter.contact_us, jitter_us);
  }
  floor.json = {{"pairs", kPairs},
                {"pair_s", settings.duration_s},
                {"cyclictest_p99_us", theirs_us},
                {"jitter_p99_us", ours_us},
                {"ratios", ratios},
                {"ratio_p99_median", percentiles(ratios).p50},
                {"remark", remark}};
  return floor;
}

}  // namespace thenar::app
