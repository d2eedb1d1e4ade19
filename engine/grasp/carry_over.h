// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// Returns the tick of `to` at the time of a tick of `from`: their steps may differ.
[[nodiscard]] std::int64_t same_time(const Model& from, std::int64_t tick, const Model& to);

/// Converts a state of one model to another with the same hand and object, but perhaps another step and fingertips with
/// other control points. These take their displacements from the old ones around them, and forces and loads go to
/// the nearest. Between equal models the state is unchanged.
[[nodiscard]] State carry_over(const Model& from, const State& state, const Model& to);

}  // namespace thenar
