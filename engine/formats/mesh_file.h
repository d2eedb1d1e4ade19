// SPDX-License-Identifier: Apache-2.0
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
///   .off   Geomview's Object File Format in text; also its variants with colours, normals or a fourth coordinate
///   .obj   Wavefront's, of which the lines `v` and `f` are read
///   .stl   stereolithography, in text or binary
///   .ply   of one that has faces: ply_file.h
///   .glb .gltf  glTF 2.0: gltf_file.h
/// Texts may be in UTF-8 or UTF-16. A fourth coordinate w divides the others. What was passed over is added to `notes`.
/// Throws FileError with the name `file` and the line or byte. Takes memory in proportion to the bytes.
[[nodiscard]] TriangleMesh parse_mesh(std::string_view bytes, const std::filesystem::path& file,
                                      std::vector<std::string>& notes);

/// Mends a mesh, by mend(), and adds what was done to `notes`. Throws FileError for one whose faces enclose nothing.
void mend_mesh(TriangleMesh& mesh, const std::filesystem::path& file, std::vector<std::string>& notes);

/// Draws `samples` blue-noise samples of a mended mesh with their normals. What lies inside another of its solids has
/// none. Throws FileError.
[[nodiscard]] PointCloud sample_mended_mesh(const TriangleMesh& mesh, const std::filesystem::path& file,
                                            Eigen::Index samples, std::vector<std::string>& notes);

}  // namespace thenar
