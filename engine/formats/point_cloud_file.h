#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

struct CloudOptions {
  double unit_m = 1.0;       ///< What 1 in the file measures.
  Eigen::Index samples = 0;  ///< Of a mesh's surface; a cloud brings its own points.
};

/// Whether the name is one of a mesh, whose surface is to be sampled: .obj, .stl or .off.
[[nodiscard]] bool is_mesh_file(const std::filesystem::path& file);

/// Whether the name is one of a surface that is read here.
[[nodiscard]] bool is_surface_file(const std::filesystem::path& file);

/// Reads a surface, by the ending of the file's name:
///   .ply              points, ascii or binary: ply_file.h
///   .xyz, .pcd        points, ascii: text_cloud_file.h
///   .obj .stl .off    a mesh, whose faces are sampled: mesh_file.h
/// Points have normals, which are normalised, or none, and then the cloud has none: see estimate_normals() in
/// collision/normal_estimation.h. What was mended is added to `notes`, one sentence each.
///
/// Throws FileError for all that is no such surface: a broken or truncated file, values that are not finite, normals of
/// zero length, fewer than 10 points, points on one line, and sizes that no hand grasps: below 1 mm or above 2 m.
[[nodiscard]] PointCloud load_cloud(const std::filesystem::path& file, const CloudOptions& options,
                                    std::vector<std::string>& notes);

/// The same from the bytes of a file of that name.
[[nodiscard]] PointCloud parse_cloud(std::string_view bytes, const std::filesystem::path& file,
                                     const CloudOptions& options, std::vector<std::string>& notes);

}  // namespace thenar
