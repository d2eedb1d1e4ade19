// SPDX-License-Identifier: Apache-2.0
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

/// Lets a cycle begin with its least corner, and go on to the lesser of its neighbours; false: that is the other way
/// round.
bool order_cycle(std::vector<int>& cycle) {
  std::rotate(cycle.begin(), std::ranges::min_element(cycle), cycle.end());
  if (cycle[1] <= cycle.back()) return true;
  std::reverse(cycle.begin() + 1, cycle.end());
  return false;
}

}  // namespace

std::string MeshBuilder::add_vertex(const Eigen::Vector3d& vertex) {
  if (vertices() == kMostVertices) return "has too many vertices";
  vertices_.insert(vertices_.end(), vertex.begin(), vertex.end());
  return "";
}

std::string MeshBuilder::add_face(std::vector<int> corners) {
  if (corners.empty()) return "";
  if (corners.size() != 3) {
    const int first = corners.front();
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    while (corners.size() > 1 && corners.back() == corners.front()) corners.pop_back();
    if (corners.size() < 3) corners.assign(3, first);  // Without area, as a point or a line is: mend() counts it.
  }
  if (corners.size() > kMostCorners) return "a face must not have more than 1000 corners: cut it into triangles";
  if (corners.size() == 3) {
    triangles_.insert(triangles_.end(), corners.begin(), corners.end());
    return "";
  }
  if (const auto side = repeated_side(corners)) {
    return "a face goes round more than once: from its corner " + std::to_string(side->first + 1) + " to " +
           std::to_string(side->second + 1) + " twice";
  }
  add_polygon(corners);
  return "";
}

void MeshBuilder::add_polygon(const std::vector<int>& corners) {
  std::vector<int> cycle;
  bool is_own = true;
  if (corners.size() > 4) {
    cycle = corners;
    is_own = order_cycle(cycle);
    if (const auto earlier = cuts_.find(cycle); earlier != cuts_.end()) {
      const bool is_same = is_own == earlier->second.is_own;
      for (std::size_t i = earlier->second.begin; i < earlier->second.end; i += 3) {
        const int a = triangles_[i], b = triangles_[i + 1], c = triangles_[i + 2];
        triangles_.insert(triangles_.end(), {a, is_same ? b : c, is_same ? c : b});
      }
      return;
    }
  }
  const std::size_t begin = triangles_.size();
  const Eigen::Map<const Eigen::Matrix3Xd> all(vertices_.data(), 3, static_cast<Index>(vertices()));
  for (const Eigen::Vector3i& triangle : cut_polygon(all(Eigen::all, corners))) {
    for (const int corner : triangle) triangles_.push_back(corners[corner]);
  }
  if (!cycle.empty()) cuts_.emplace(std::move(cycle), Cut{begin, triangles_.size(), is_own});
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
