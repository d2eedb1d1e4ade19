// SPDX-License-Identifier: Apache-2.0
// What touch costs a contact tick: that of the box grasp while the box is on its way, at 60 contacts, with what
// fingertips feel and without. Both make the same ticks, to the last bit, again and again. The difference is a
// hundredth of a tick: take many repetitions in turns,
//
//     ./dev bench touch --benchmark_repetitions=20 --benchmark_enable_random_interleaving=true

#include "bench/cases/timed_ticks.h"

namespace thenar {
namespace {

constexpr Eigen::Index kContacts = 60;

void contact_tick_of(benchmark::State& bench, bool feels) {
  static const TimedTicks feeling(kContacts, {"fingertips.touch={}"}), unfeeling(kContacts, {});
  (feels ? feeling : unfeeling).time(bench);
}

BENCHMARK_CAPTURE(contact_tick_of, 60_contacts, false)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(contact_tick_of, 60_contacts_that_feel, true)->UseManualTime()->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace thenar
