#pragma once

#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/loops/threads.h"
#include "engine/results/monolithic.h"
#include "engine/results/profile.h"
#include "engine/results/recording.h"
#include "engine/results/recording_file.h"

namespace thenar {

/// What a run on two threads leaves.
struct RealtimeRun {
  Recording recording;
  ThreadsReport report;
};

/// Runs a scene by run_threads, as run_monolithic does in one loop: to its end, or until the object is lost or no grasp
/// forces exist at the start. Ticks that slipped are not in the recording and do not count as missing: simulated time
/// lags. The fingertips are not shown. `settings` says how; its callbacks are not called.
/// `profile` receives every tick, and `film`, if there is one, what it looks like; throws FileError. A state that
/// nobody had time for is missing there.
[[nodiscard]] RealtimeRun run_realtime(const Model& model, State& state, ThreadSettings settings, LoopProfile& profile,
                                       const Progress& progress = {}, RecordingFile* film = nullptr);

}  // namespace thenar
