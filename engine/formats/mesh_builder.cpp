#include "engine/formats/mesh_builder.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace thenar {

using Eigen::Index;

namespace {

// More corners than the end of any cylinder has; cutting up a face takes their square in time.
constexpr std::size_t kMostCorners = 1000;
constexpr std::size_t kMostVertices = 1'000'000'000;  // numbers of vertices are 32 bits wide

/// Returns a side that a face has twice in the same direction; nothing if it has none. The bridge to a hole in a face
/// runs along the same corners once there and once back.
std::optional<std::pair<int, int>> repeated_side(const std::vector<int>& corners) {
  std::vector<std::pair<int, int>> sides;
  for (std::size_t i = 0; i < corners.size(); ++i) sides.emplace_back(corners[i], corners[(i + 1) % corners.size()]);
  std::ranges::sort(sides);
  const auto found = std::ranges::adjacent_find(sides);
  return found == sides.end() ? std::nullopt : std::optional(*found);
}

}  // namespace

std::string MeshBuilder::add_vertex(const Eigen::Vector3d& vertex) {
  if (vertices() == kMostVertices) return "has too many vertices";
  vertices_.insert(vertices_.end(), vertex.begin(), vertex.end());
  return "";
}

std::string MeshBuilder::add_face(std::vector<int> corners) {
  if (corners.size() < 3) return "a face needs at least three corners";
  if (corners.size() > 3) {
    const int first = corners.front();
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    while (corners.size() > 1 && corners.back() == corners.front()) corners.pop_back();
    if (corners.size() < 3) corners.assign(3, first);  // Without area: mend() counts it.
  }
  if (corners.size() > kMostCorners) return "a face must not have more than 1000 corners";
  if (corners.size() == 3) {
    triangles_.insert(triangles_.end(), corners.begin(), corners.end());
    return "";
  }
  if (const auto side = repeated_side(corners)) {
    return "a face goes round more than once: from its corner " + std::to_string(side->first + 1) + " to " +
           std::to_string(side->second + 1) + " twice";
  }
  const Eigen::Map<const Eigen::Matrix3Xd> all(vertices_.data(), 3, static_cast<Index>(vertices()));
  for (const Eigen::Vector3i& triangle : cut_polygon(all(Eigen::all, corners))) {
    for (const int corner : triangle) triangles_.push_back(corners[corner]);
  }
  return "";
}

void MeshBuilder::add_triangle() {
  const auto end = static_cast<int>(vertices());
  triangles_.insert(triangles_.end(), {end - 3, end - 2, end - 1});
}

TriangleMesh MeshBuilder::mesh() const {
  return {Eigen::Map<const Eigen::Matrix3Xd>(vertices_.data(), 3, std::ssize(vertices_) / 3),
          Eigen::Map<const Eigen::Matrix3Xi>(triangles_.data(), 3, std::ssize(triangles_) / 3)};
}

}  // namespace thenar
