#pragma once

#include <filesystem>
#include <string_view>

#include "collision/point_cloud.h"

namespace thenar {

enum class PlyFormat { kAscii, kBinaryLittleEndian, kBinaryBigEndian };

/// The element `vertex` of a PLY file: x, y, z and, where it has them, nx, ny, nz, of any numeric type and as they are.
/// Other properties and elements, lists too, are skipped.
/// Throws FileError with the name `file` for what is no PLY file, and for one that is broken or truncated. Takes memory
/// in proportion to the bytes, whatever the header claims.
[[nodiscard]] PointCloud parse_ply(std::string_view bytes, const std::filesystem::path& file);

/// Writes the points and normals as doubles that are read back the same. Throws FileError.
void save_ply(const std::filesystem::path& file, const PointCloud& cloud, PlyFormat format);

}  // namespace thenar
