// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "bench/cases/recorded.h"
#include "engine/loops/percentiles.h"
#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

/// The box grasp with so many contacts while the box is on its way: the run as it stands before a hundred ticks, those
/// of recorded_run(). For suites that compare a tick with one in which something more is done.
struct TimedTicks {
  static constexpr int kFrom = 700, kTo = 800;

  TimedTicks(Eigen::Index of_contacts, const std::vector<std::string>& more)
      : contacts(of_contacts), model(changed(contacts, more)), run(model) {
    while (run.state.tick < kFrom) run.tick();
  }

  /// Makes these contact ticks again and again, with their control ticks, which are not timed.
  void time(benchmark::State& bench) const;

  Eigen::Index contacts;
  Model model;
  GraspRun run;

 private:
  static Model changed(Eigen::Index of_contacts, const std::vector<std::string>& more) {
    std::vector<std::string> changes = changes_for(of_contacts);
    changes.insert(changes.end(), more.begin(), more.end());
    return build_model(load_scene(THENAR_CONFIGS "/box_grasp.yaml", changes));
  }
};

inline void TimedTicks::time(benchmark::State& bench) const {
  using Clock = std::chrono::steady_clock;
  GraspRun again(model);
  std::vector<double> took_us;
  double worst = 0.0, sweeps = 0.0;
  Eigen::Index fewest = contacts;
  for (auto _ : bench) {
    if (again.state.tick < kFrom || again.state.tick >= kTo) again.go_on_as(run);
    again.control_if_due();
    const Clock::time_point from = Clock::now();
    const TickReport tick = again.contact();
    took_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - from).count());
    bench.SetIterationTime(1e-6 * took_us.back());
    worst = std::max(worst, tick.solve.residual);
    fewest = std::min(fewest, tick.contacts);
    sweeps += tick.solve.sweeps;
  }
  bench.counters["median_us"] = percentiles(took_us).p50;  // What else the machine does is in the mean.
  bench.counters["worst_residual"] = worst;
  bench.counters["sweeps"] = benchmark::Counter(sweeps, benchmark::Counter::kAvgIterations);
  if (fewest < contacts) bench.SkipWithError("a tick has fewer contacts");
  if (worst > model.scene.contact.tolerance) bench.SkipWithError("a tick did not converge");
}

}  // namespace thenar
