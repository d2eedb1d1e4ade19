// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

/// Reads an XYZ file: a point per line, `x y z` or `x y z nx ny nz`, with blanks, commas or semicolons between the
/// numbers, the same in every line. '#' and "//" begin a comment. Before the points there may be their number in a line
/// of its own, and a title, whose names, if they have x, y, z or nx, ny, nz among them, say which columns these are.
/// Three columns without a name are normals if they are of unit length; the others, such as colours and intensities,
/// are passed over, and `notes` say what was taken. A file may have any columns. Values may be nan.
/// Throws FileError with the name `file` and the line.
[[nodiscard]] PointCloud parse_xyz(std::string_view bytes, const std::filesystem::path& file,
                                   std::vector<std::string>& notes);

}  // namespace thenar
