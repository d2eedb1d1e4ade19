// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>

#include "engine/insertion/insertion.h"

namespace thenar {

/// Files that write_insertion() may write to a folder.
inline constexpr std::array kInsertionFiles{"insertion.json", "insertion.csv", "insertion.svg"};

/// Writes all results as insertion.json, the ticks as insertion.csv, and insertion.svg, which is drawn from these: the
/// jamming diagram, whose parallelograms grow with the depth, and the run's path through it; and F_z and the tilt over
/// the depth, with the theory. Without friction there is no diagram. Returns false if there is no figure, as gnuplot is
/// missing or failed. Throws FileError.
[[nodiscard]] bool write_insertion(const Scene& scene, const InsertionStudy& study,
                                   const std::filesystem::path& folder);

}  // namespace thenar
