#pragma once

#include <filesystem>
#include <string_view>

#include "collision/point_cloud.h"

namespace thenar {

enum class PlyFormat { kAscii, kBinaryLittleEndian, kBinaryBigEndian };

/// Reads the element `vertex` of a PLY file: x, y, z and, where it has them, nx, ny, nz, of any numeric type, unscaled.
/// Other properties and elements, lists too, are skipped. Throws FileError with the name `file` if it is no PLY file,
/// or broken or truncated. Takes memory in proportion to the bytes, whatever the header claims.
[[nodiscard]] PointCloud parse_ply(std::string_view bytes, const std::filesystem::path& file);

/// Writes the points and normals as doubles that are read back the same. Throws FileError.
void save_ply(const std::filesystem::path& file, const PointCloud& cloud, PlyFormat format);

}  // namespace thenar
