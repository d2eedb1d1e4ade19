// SPDX-License-Identifier: Apache-2.0
// What an environment costs a contact tick: that of the box grasp with 60 contacts while the box is on its way, over a
// bed of so many balls that press against it from below. Take many repetitions in turns,
//
//     ./dev bench environment --benchmark_repetitions=20 --benchmark_enable_random_interleaving=true

#include <map>

#include "bench/cases/bed_of_balls.h"
#include "bench/cases/timed_ticks.h"

namespace thenar {
namespace {

constexpr Eigen::Index kContacts = 60;

void contact_tick_over(benchmark::State& bench) {
  static std::map<int, TimedTicks> runs;
  const int n = static_cast<int>(bench.range(0));
  const auto run = runs.try_emplace(n, kContacts, bed_of_balls(n)).first;
  run->second.time(bench);
}

BENCHMARK(contact_tick_over)
    ->Arg(0)
    ->Arg(8)
    ->Arg(32)
    ->Arg(72)
    ->Arg(128)
    ->Arg(200)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace thenar
