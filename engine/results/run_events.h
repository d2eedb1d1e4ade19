// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/grasp/scene.h"
#include "engine/results/recording.h"

namespace thenar {

/// Something that happened in a run.
struct RunEvent {
  double time_s = 0.0;
  std::string what;  ///< In a few words: "friction falls to 0.15".
};

/// Returns what happened in a run, in the order of time: what the scene does at set times (friction, a push, a turn of
/// the target), the phases of its task, when the grip answered what fingertips felt, and when the object was lost.
[[nodiscard]] std::vector<RunEvent> run_events(const Scene& scene, const Recording& recording);

}  // namespace thenar
