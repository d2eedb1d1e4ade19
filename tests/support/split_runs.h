// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "engine/loops/split_grasp.h"

namespace thenar::split_runs {

/// Both loops on one thread, from the grasp's tick to another.
inline void run(SplitGrasp& grasp, std::int64_t end) {
  while (grasp.state().tick < end) {
    if (grasp.state().tick > 0 && grasp.model().control_is_due(grasp.state().tick)) grasp.control_step();
    grasp.contact_step();
  }
}

}  // namespace thenar::split_runs
