// SPDX-License-Identifier: Apache-2.0
// What muscles that act cost a contact tick: that of the box grasp while the box is on its way, at 60 contacts, with
// muscles that only share the torques out, with muscles that have stiffness, and with such that take time as well. The
// ticks are not the same, so sweeps are told beside the time. Take many repetitions in turns,
//
//     ./dev bench muscles --benchmark_repetitions=20 --benchmark_enable_random_interleaving=true

#include "bench/cases/timed_ticks.h"

namespace thenar {
namespace {

constexpr Eigen::Index kContacts = 60;
constexpr std::array kMuscles{"true", "{stiffness: 23.4}", "{stiffness: 23.4, activation: 10 ms}"};

void contact_tick_of(benchmark::State& bench, int which) {
  static const std::array<TimedTicks, kMuscles.size()> runs = [] {
    const auto with = [](const char* muscles) {
      return TimedTicks(kContacts, {std::string("control.muscles=") + muscles});
    };
    return std::array{with(kMuscles[0]), with(kMuscles[1]), with(kMuscles[2])};
  }();
  runs[which].time(bench);
}

BENCHMARK_CAPTURE(contact_tick_of, 60_contacts, 0)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(contact_tick_of, 60_contacts_of_stiff_muscles, 1)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(contact_tick_of, 60_contacts_of_slow_stiff_muscles, 2)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace thenar
