#pragma once

#include <functional>

#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/results/problem_dump.h"
#include "engine/results/recording.h"
#include "engine/results/recording_file.h"

namespace thenar {

/// Called after every tick with simulated time and wall time so far [s]. False ends the run there: it is an interrupted
/// one.
using Progress = std::function<bool(double simulated_s, double wall_s)>;

/// Runs a scene as the paper does, in one loop: a control tick every control period and a contact tick every step, on
/// one thread, to the end of the scene or until the object is lost or no grasp forces exist at the start. The deformed
/// fingertips are shown at every sample after every tick, as a viewer would need them. `state` is left as the run
/// ended. The same scene gives the same bits. `dump`, if there is one, writes problems of the run, and `film` what it
/// looks like: what the disk refuses them they report at their end.
[[nodiscard]] Recording run_monolithic(const Model& model, State& state, const Progress& progress = {},
                                       ProblemDump* dump = nullptr, RecordingFile* film = nullptr);

}  // namespace thenar
