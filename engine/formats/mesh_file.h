#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "collision/point_cloud.h"
#include "collision/triangle_mesh.h"

namespace thenar {

/// Reads the faces of a mesh as triangles, in the file's units and orientation. Polygons are triangulated by ear
/// clipping; colours, normals, textures and materials are skipped. The extension selects the format:
///   .off Geomview's Object File Format in text; also its variants with colours or normals
///   .obj   Wavefront's, of which the lines `v` and `f` are read
///   .stl   stereolithography, in text or binary
/// Throws FileError with the name `file` and the line or byte. Takes memory in proportion to the bytes.
[[nodiscard]] TriangleMesh parse_mesh(std::string_view bytes, const std::filesystem::path& file);

/// Draws `samples` blue-noise samples of the faces with their normals. Repairs are added to `notes`: triangles without
/// area are left out, those of wrong orientation are reversed.
/// Throws FileError for a file that is broken, or whose faces enclose nothing.
[[nodiscard]] PointCloud sample_mesh_file(std::string_view bytes, const std::filesystem::path& file,
                                          Eigen::Index samples, std::vector<std::string>& notes);

}  // namespace thenar
