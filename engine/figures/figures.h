// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>

#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/results/recording.h"

namespace thenar {

/// Files that draw_figures() may leave in a folder.
inline constexpr std::array<const char*, 6> kFigures{"path.svg",    "forces.svg", "grip.svg",
                                                     "muscles.svg", "task.svg",   "grasp.png"};

/// Draws path.svg (Fig. 9 of the paper), forces.svg (Fig. 10), grip.svg, muscles.svg and task.svg from the folder's
/// signals.csv, and grasp.png, the hand and the object as the run left them. What a scene does not have is not drawn.
/// False if there is no gnuplot or it failed. Throws FileError if a figure cannot be written.
[[nodiscard]] bool draw_figures(const Model& model, const Recording& recording, const State& state,
                                const std::filesystem::path& folder);

}  // namespace thenar
