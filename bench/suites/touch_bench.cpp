// What touch costs a contact tick: that of the box grasp while the box is on its way, at 60 contacts, with what
// fingertips feel and without. Both make the same ticks, to the last bit, again and again. The difference is a
// hundredth of a tick: take many repetitions in turns,
//
//     ./dev bench touch --benchmark_repetitions=20 --benchmark_enable_random_interleaving=true

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "bench/cases/recorded.h"
#include "engine/loops/percentiles.h"
#include "engine/loops/run.h"
#include "engine/scenes/build_model.h"
#include "engine/scenes/scene_file.h"

namespace thenar {
namespace {

constexpr Eigen::Index kContacts = 60;
constexpr int kFrom = 700, kTo = 800;  // Ticks, those of recorded_run().

Model box(bool feels) {
  std::vector<std::string> changes = changes_for(kContacts);
  if (feels) changes.emplace_back("fingertips.touch={}");
  return build_model(load_scene(THENAR_CONFIGS "/box_grasp.yaml", changes));
}

/// The run as it stands before the first of these ticks.
struct Started {
  explicit Started(bool feels) : model(box(feels)), run(model) {
    while (run.state.tick < kFrom) run.tick();
  }
  Model model;
  GraspRun run;
};

const Started& started(bool feels) {
  static const Started feeling(true), unfeeling(false);
  return feels ? feeling : unfeeling;
}

void contact_tick_of(benchmark::State& bench, bool feels) {
  using Clock = std::chrono::steady_clock;
  const Started& start = started(feels);
  GraspRun run(start.model);
  std::vector<double> took_us;
  double worst = 0.0, sweeps = 0.0;
  Eigen::Index fewest = kContacts;
  for (auto _ : bench) {
    if (run.state.tick < kFrom || run.state.tick >= kTo) run.go_on_as(start.run);
    run.control_if_due();
    const Clock::time_point from = Clock::now();
    const TickReport tick = run.contact();
    took_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - from).count());
    bench.SetIterationTime(1e-6 * took_us.back());
    worst = std::max(worst, tick.solve.residual);
    fewest = std::min(fewest, tick.contacts);
    sweeps += tick.solve.sweeps;
  }
  bench.counters["median_us"] = percentiles(took_us).p50;  // What else the machine does is in the mean.
  bench.counters["worst_residual"] = worst;
  bench.counters["sweeps"] = benchmark::Counter(sweeps, benchmark::Counter::kAvgIterations);
  if (fewest < kContacts) bench.SkipWithError("a tick has fewer contacts");
  if (worst > start.model.scene.contact.tolerance) bench.SkipWithError("a tick did not converge");
}

BENCHMARK_CAPTURE(contact_tick_of, 60_contacts, false)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(contact_tick_of, 60_contacts_that_feel, true)->UseManualTime()->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace thenar
