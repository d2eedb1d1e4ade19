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

/// Tests whether the name is that of a mesh, whose surface is to be sampled: .obj, .stl or .off.
[[nodiscard]] bool is_mesh_file(const std::filesystem::path& file);

/// Tests whether the name is that of a surface that load_cloud() reads.
[[nodiscard]] bool is_surface_file(const std::filesystem::path& file);

/// Reads a surface, by the extension of the file's name:
///   .ply              points, ascii or binary: ply_file.h
///   .xyz, .pcd        points, ascii: text_cloud_file.h
///   .obj .stl .off    a mesh, whose faces are sampled: mesh_file.h
/// Points have normals, which are normalised, or none, and then the cloud has none: see estimate_normals() in
/// collision/normal_estimation.h. Repairs are added to `notes`, one sentence each.
///
/// Throws FileError for an invalid surface: a broken or truncated file, values that are not finite, normals of zero
/// length, fewer than 10 points, points on one line, and sizes that no hand grasps: below 1 mm or above 2 m.
[[nodiscard]] PointCloud load_cloud(const std::filesystem::path& file, const CloudOptions& options,
                                    std::vector<std::string>& notes);

/// Reads a surface from the bytes of a file of that name.
[[nodiscard]] PointCloud parse_cloud(std::string_view bytes, const std::filesystem::path& file,
                                     const CloudOptions& options, std::vector<std::string>& notes);

}  // namespace thenar
