// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "engine/control/control_period.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/loops/run.h"
#include "engine/loops/threads.h"
#include "engine/results/profile.h"
#include "engine/results/recording.h"

namespace thenar {

/// Called after every tick with simulated time and wall time so far [s]. False ends the run there: it is an interrupted
/// one.
using Progress = std::function<bool(double simulated_s, double wall_s)>;

struct RunSettings {
  std::optional<LockstepSettings> lockstep = {};  ///< Nothing: in one loop.
  OwnControl own = {};                            ///< Instead of parts of the published controller.
  Progress progress = {};
  std::vector<Watcher*> watchers = {};  ///< Beside the recorder.
  bool shows = true;                    ///< In one loop, the fingertips: see run_ticks().
};

/// Runs a scene on one thread, to its end or until the object is lost or no grasp forces exist at the start. `state` is
/// left as the run ended. The same scene gives the same bits.
[[nodiscard]] Recording run_scene(const Model& model, State& state, const RunSettings& settings = {});

/// The same by run_threads, in real time. Ticks that slipped are not in the recording and do not count as missing:
/// simulated time lags. The fingertips are not shown. `settings` says how; its callbacks are not called, except
/// on_start and on_look. `watchers` see the ticks as the recorder does, on the calling thread, with the pictures of the
/// tap of `settings.live`, if it has one. With `settings.live` people act on the run.
[[nodiscard]] RealtimeRun run_realtime(const Model& model, State& state, ThreadSettings settings,
                                       const Progress& progress = {}, const std::vector<Watcher*>& watchers = {});

}  // namespace thenar
