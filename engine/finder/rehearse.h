#pragma once

#include "engine/finder/found_grasp.h"
#include "engine/grasp/model.h"

namespace thenar {

/// Runs the scene's own task, or where it has none a carry of 20 mm along the grasp's travel and pushes of 0.5 N in six
/// directions, by steps of 2 ms, of fine parts of 4 ms: the engine itself, one loop, but coarser in time than most
/// scenes are. `model` is settled, and is given back as it was.
[[nodiscard]] Rehearsal rehearse(Model& model, const FoundGrasp& grasp);

}  // namespace thenar
