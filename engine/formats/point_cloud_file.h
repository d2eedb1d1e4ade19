// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

struct CloudOptions {
  double unit_m = 1.0;       ///< Length of the file's unit.
  Eigen::Index samples = 0;  ///< Number of samples of a mesh's surface; a cloud has its own points.
};

/// Tests for a mesh, whose surface is to be sampled: .obj, .stl, .off, .glb, .gltf, or a .ply that can be read and
/// declares faces.
[[nodiscard]] bool is_mesh_file(const std::filesystem::path& file);

/// Tests whether the name is that of a surface that load_cloud() reads.
[[nodiscard]] bool is_surface_file(const std::filesystem::path& file);

/// Reads a surface, by the extension of the file's name:
///   .ply         points, or a mesh: ply_file.h
///   .xyz         points in a text: text_cloud_file.h; also .asc, .csv, .pts, .txt, .xyzn and .xyzrgb
///   .pcd         points of the Point Cloud Library: pcd_file.h
///   .obj .stl .off .glb .gltf  a mesh, whose faces are sampled: mesh_file.h
/// Points have normals, which are normalised, or none, and then the cloud has none: see estimate_normals() in
/// collision/normal_estimation.h. Points that are missing (nan) are left out, as are those whose normal is missing or
/// zero; normals are, if that is more than half of them. Repairs are added to `notes`, one sentence each.
///
/// Throws FileError for an invalid surface: a broken or truncated file, fewer than 10 points, points on one line, and
/// sizes that no hand grasps: below 1 mm or above 2 m.
[[nodiscard]] PointCloud load_cloud(const std::filesystem::path& file, const CloudOptions& options,
                                    std::vector<std::string>& notes);

/// Reads a surface from the bytes of a file of that name.
[[nodiscard]] PointCloud parse_cloud(std::string_view bytes, const std::filesystem::path& file,
                                     const CloudOptions& options, std::vector<std::string>& notes);

}  // namespace thenar
