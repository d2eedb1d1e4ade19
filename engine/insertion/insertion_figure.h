#pragma once

#include <array>
#include <filesystem>

#include "engine/insertion/insertion.h"

namespace thenar {

/// What write_insertion() may leave in a folder.
inline constexpr std::array kInsertionFiles{"insertion.json", "insertion.csv", "insertion.svg"};

/// Writes all figures as insertion.json, the ticks as insertion.csv, and insertion.svg, which is drawn from these: the
/// jamming diagram, whose parallelograms grow with the depth, and the run's way through it; and F_z and the tilt over
/// the depth, with what theory has. Without friction there is no diagram. False if there is no figure, for gnuplot is
/// missing or failed. Throws FileError.
[[nodiscard]] bool write_insertion(const Scene& scene, const InsertionStudy& study,
                                   const std::filesystem::path& folder);

}  // namespace thenar
