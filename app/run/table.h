// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/loops/realtime.h"
#include "engine/results/run_measures.h"

namespace thenar::app {

/// The measures of a run as one table for people, heading by heading, below the build and what the contact thread of a
/// run on two threads was granted; null: it ran on one.
[[nodiscard]] std::string results_table(const std::vector<MeasuredSection>& measures, const Scheduling* granted);

}  // namespace thenar::app
