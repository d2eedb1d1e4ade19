// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/loops/realtime.h"

namespace thenar::app {

/// Runs cyclictest (Debian's package rt-tests), a loop that does nothing but start on time, with a contact thread's
/// period, policy, priority, core and timer slack, its memory locked, on the same clock. It has no short turns, which a
/// contact thread asks for where SCHED_FIFO is refused. Returns its start jitters in us, sorted, one a loop: counted in
/// ns up to 1 ms, the longer ones all as the longest. Returns nothing if it is not installed or was refused.
[[nodiscard]] std::optional<std::vector<double>> run_cyclictest(const Scheduling& scheduling, double period_s,
                                                                std::int64_t loops);

}  // namespace thenar::app
