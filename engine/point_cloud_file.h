#pragma once

#include <filesystem>

#include "collision/point_cloud.h"

namespace thenar {

/// Reads a surface from a PLY file: the element `vertex` with x, y, z in metres and outward normals nx, ny, nz, of any
/// numeric type, in ascii or binary little-endian. Other properties and elements, lists too, are skipped.
///
/// Throws FileError for all that is no such surface: a broken or truncated file, values that are not finite, normals of
/// zero length, fewer than 10 points, or points on one line. Normals are normalised. Takes memory in proportion to the
/// file, whatever its header claims.
[[nodiscard]] PointCloud load_ply(const std::filesystem::path& file);

enum class PlyFormat { kAscii, kBinaryLittleEndian };

/// Writes the points and normals as doubles that load_ply() reads back the same. Throws FileError.
void save_ply(const std::filesystem::path& file, const PointCloud& cloud, PlyFormat format);

}  // namespace thenar
