// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// A gnuplot script that draws the hand, its deformed fingertips and the object of a state as a PNG: an orthographic
/// view across the grip, forces as arrows.
[[nodiscard]] std::string grasp_picture_script(const Model& model, const State& state);

}  // namespace thenar
