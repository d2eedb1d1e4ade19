// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collision/point_cloud.h"
#include "collision/triangle_mesh.h"

namespace thenar {

enum class PlyFormat { kAscii, kBinaryLittleEndian, kBinaryBigEndian };

/// What a PLY file holds, unscaled.
struct PlyFile {
  PointCloud cloud;                  ///< The element `vertex`: x, y, z and, where it has them, nx, ny, nz.
  std::optional<TriangleMesh> mesh;  ///< Nothing without faces.
};

/// Reads a PLY file [Turk 1994], in which numbers have any type and elements any order. Faces are the lists
/// `vertex_indices` or `vertex_index` of an element `face`, or of `tristrips`, in which -1 begins another strip. Other
/// properties and elements are skipped. A header's line that none knows, and bytes behind the last record that are too
/// few for another one, are passed over, which is added to `notes`.
/// Throws FileError with the name `file` if it is no PLY file, or broken or truncated. Takes memory in proportion to
/// the bytes, whatever the header claims.
[[nodiscard]] PlyFile parse_ply(std::string_view bytes, const std::filesystem::path& file,
                                std::vector<std::string>& notes);

/// Tests whether the header of a PLY file declares faces.
[[nodiscard]] bool ply_has_faces(std::string_view bytes);

/// Writes the points and normals as doubles that are read back the same. Throws FileError.
void save_ply(const std::filesystem::path& file, const PointCloud& cloud, PlyFormat format);

}  // namespace thenar
