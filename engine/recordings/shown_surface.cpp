// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/shown_surface.h"

#include <optional>
#include <string>
#include <vector>

#include "collision/closed_surface.h"
#include "engine/formats/files.h"
#include "engine/formats/mesh_file.h"
#include "engine/formats/point_cloud_file.h"

namespace thenar {
namespace {

constexpr Eigen::Index kMostTriangles = 100'000;  // 2 MB of a message

/// The mesh of the object's file; nothing if it is none that can be shown.
std::optional<TriangleMesh> own_mesh(const CloudShape& scan) try {
  if (!is_mesh_file(scan.file)) return std::nullopt;
  std::vector<std::string> told;  // when the scene was read
  TriangleMesh mesh = parse_mesh(read_file(scan.file), scan.file, told);
  if (mesh.triangles.cols() > kMostTriangles) return std::nullopt;
  const MeshMending mending = mend(mesh);
  mesh.vertices_m *= scan.unit_m;
  return mending.open_edges > 0 || mending.at_odds > 0 ? std::nullopt : std::optional(mesh);
} catch (const FileError&) {  // It was another one when the scene was read.
  return std::nullopt;
}

}  // namespace

TriangleMesh shown_surface(const Model& model) {
  std::optional<TriangleMesh> mesh;
  if (const auto* const scan = std::get_if<CloudShape>(&model.scene.object.shape)) mesh = own_mesh(*scan);
  if (!mesh) mesh = closed_surface(model.object);
  return std::move(mesh).value_or(TriangleMesh{});
}

}  // namespace thenar
