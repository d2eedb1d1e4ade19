#pragma once

#include <filesystem>
#include <string>

#include "engine/model.h"
#include "engine/state.h"

namespace thenar {

/// A gnuplot script that draws the hand, its deformed fingertips and the object of a state to a PNG file: an
/// orthographic view across the grip, forces as arrows.
[[nodiscard]] std::string grasp_picture_script(const Model& model, const State& state,
                                               const std::filesystem::path& file);

}  // namespace thenar
