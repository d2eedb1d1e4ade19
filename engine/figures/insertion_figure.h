#pragma once

#include <filesystem>
#include <string>

namespace thenar {

/// What a figure of an insertion is drawn to.
struct InsertionScales {
  double friction = 0.0;
  double radius_m = 0.0;
  double play_m = 0.0;  ///< D - d.
  double chamfer_m = 0.0;
  double deepest_m = 0.0;  ///< Of the peg's end below the plate.
  std::string title;
};

/// What draw_insertion() may leave in a folder.
inline constexpr const char* kInsertionFigure = "insertion.svg";

/// Draws insertion.svg from the folder's insertion.csv: the jamming diagram, whose parallelograms grow with the depth,
/// and the run's way through it; and F_z and the tilt over the depth, with what theory has. Without friction
/// there is no diagram. False if there is no gnuplot or it failed. Throws FileError if the figure cannot be written.
[[nodiscard]] bool draw_insertion(const InsertionScales& scales, const std::filesystem::path& folder);

}  // namespace thenar
