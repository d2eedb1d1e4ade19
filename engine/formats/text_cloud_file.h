#pragma once

#include <filesystem>
#include <string_view>

#include "collision/point_cloud.h"

namespace thenar {

/// Reads an XYZ file: a point per line, `x y z` or `x y z nx ny nz`, the same in every line; text after a '#' is a
/// comment. Throws FileError with the name `file` and the line.
[[nodiscard]] PointCloud parse_xyz(std::string_view bytes, const std::filesystem::path& file);

/// Reads an ascii PCD file of the Point Cloud Library: the fields x, y, z and, where it has them, normal_x, normal_y,
/// normal_z. Other fields are skipped. Throws FileError with the name `file` and the line.
[[nodiscard]] PointCloud parse_pcd(std::string_view bytes, const std::filesystem::path& file);

}  // namespace thenar
