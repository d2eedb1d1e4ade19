// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/finder/found_grasp.h"
#include "engine/grasp/model.h"

namespace thenar {

/// Simulates the scene's own task, or where it has none a carry of 20 mm in the grasp's best direction and pushes of
/// 0.5 N in six directions, in steps of 2 ms, of fine parts of 4 ms: by the engine itself in one loop, but coarser in
/// time than most scenes. `model` is settled, and is restored afterwards.
[[nodiscard]] Rehearsal rehearse(Model& model, const FoundGrasp& grasp);

}  // namespace thenar
