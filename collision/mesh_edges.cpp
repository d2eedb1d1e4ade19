// SPDX-License-Identifier: Apache-2.0
#include "collision/mesh_edges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <tuple>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// A triangle's vertices in order, and whether that turns its orientation.
struct Corners {
  std::array<int, 3> vertices;
  int along;
  Index triangle;
};

Corners corners_of(const TriangleMesh& mesh, Index triangle) {
  Corners corners{{mesh.triangles(0, triangle), mesh.triangles(1, triangle), mesh.triangles(2, triangle)}, 1, triangle};
  auto& v = corners.vertices;
  const auto order = [&](int i, int k) {
    if (v[i] <= v[k]) return;
    std::swap(v[i], v[k]);
    corners.along = -corners.along;
  };
  order(0, 1);
  order(1, 2);
  order(0, 1);
  return corners;
}

/// The edge between two triangles, and their vertices off it.
struct Diagonal {
  std::array<int, 2> edge, off;
  Index a, b;
};

/// The vertex of a side's triangle that is not on the edge.
int vertex_off(const TriangleMesh& mesh, const EdgeSide& side) {
  return mesh.triangles.col(side.triangle).sum() - side.from - side.to;
}

/// Tests for an edge of more than two triangles, or of two with the same vertices: elsewhere no face lies on another.
bool may_have_doubled(const TriangleMesh& mesh, const std::vector<EdgeSide>& sides) {
  bool may = false;
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    may = may || end - begin > 2;
    may = may || (end - begin == 2 && vertex_off(mesh, sides[begin]) == vertex_off(mesh, sides[begin + 1]));
  });
  return may;
}

/// Cuts two squares of the same four corners along the same diagonal: where two triangles of one plane lie on two
/// others that share the other diagonal. They are the two sides of a surface, or a wall between two solids.
void cut_alike(TriangleMesh& mesh, const std::vector<EdgeSide>& sides) {
  std::vector<Diagonal> diagonals;
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (end - begin != 2 || sides[begin].along == sides[begin + 1].along) return;
    const int c = vertex_off(mesh, sides[begin]), d = vertex_off(mesh, sides[begin + 1]);
    diagonals.push_back({{sides[begin].from, sides[begin].to},
                         {std::min(c, d), std::max(c, d)},
                         sides[begin].triangle,
                         sides[begin + 1].triangle});
  });
  // A triangle that was cut has other vertices than its edges here tell.
  std::vector<char> was_cut(mesh.triangles.cols(), 0);
  for (const Diagonal& one : diagonals) {
    if (one.off < one.edge) continue;  // Once for both; in the order of edges.
    const auto other = std::ranges::lower_bound(diagonals, one.off, {}, &Diagonal::edge);
    if (other == diagonals.end() || other->edge != one.off || other->off != one.edge) continue;
    if (was_cut[one.a] + was_cut[one.b] + was_cut[other->a] + was_cut[other->b] > 0) continue;
    const auto place = [&](int i) -> Vector3d { return mesh.vertices_m.col(i); };
    const Vector3d u = place(one.edge[1]) - place(one.edge[0]), v = place(one.off[0]) - place(one.edge[0]);
    const Vector3d w = place(one.off[1]) - place(one.edge[0]), n = u.cross(v);
    if (std::abs(n.dot(w)) > 1e-6 * n.norm() * w.norm()) continue;  // a tetrahedron
    // c, d, and the vertices beside them, in the direction of the first triangle: its side from c to d.
    const bool is_along = mesh.triangles(0, other->a) == other->edge[0] ? mesh.triangles(1, other->a) == other->edge[1]
                          : mesh.triangles(1, other->a) == other->edge[0]
                              ? mesh.triangles(2, other->a) == other->edge[1]
                              : mesh.triangles(0, other->a) == other->edge[1];
    const int c = other->edge[is_along ? 0 : 1], d = other->edge[is_along ? 1 : 0];
    const int x = mesh.triangles.col(other->a).sum() - c - d, y = mesh.triangles.col(other->b).sum() - c - d;
    mesh.triangles.col(other->a) << x, c, y;
    mesh.triangles.col(other->b) << y, d, x;
    was_cut[other->a] = was_cut[other->b] = 1;
  }
}

enum class Face : char { kSingle, kSheet, kLeftOut };

/// Marks all but one of the faces of the same vertices as left out: of those in the minority first. One that stands for
/// as many both ways is a sheet.
std::vector<Face> mark_doubled(const TriangleMesh& mesh) {
  std::vector<Corners> all;
  for (Index i = 0; i < mesh.triangles.cols(); ++i) all.push_back(corners_of(mesh, i));
  std::ranges::sort(all, {}, [](const Corners& c) { return std::tuple(c.vertices, c.triangle); });
  std::vector<Face> faces(all.size(), Face::kSingle);
  for (std::size_t begin = 0; begin < all.size();) {
    std::size_t end = begin + 1;
    int along = all[begin].along;
    for (; end < all.size() && all[end].vertices == all[begin].vertices; ++end) along += all[end].along;
    for (std::size_t i = begin; i < end && end - begin > 1; ++i) faces[all[i].triangle] = Face::kLeftOut;
    for (std::size_t i = begin; i < end && end - begin > 1; ++i) {
      if (along * all[i].along < 0) continue;
      faces[all[i].triangle] = along == 0 ? Face::kSheet : Face::kSingle;
      break;
    }
    begin = end;
  }
  return faces;
}

/// Sheets that are connected by edges.
struct Patch {
  Index fitting = 0;  ///< Edges of the rim that are open without the patch, less those that are closed without it.
  Eigen::AlignedBox3d box;
};

/// Marks the sheets as left out that are walls between solids.
void mark_walls(const TriangleMesh& mesh, std::vector<Face>& faces) {
  std::vector<EdgeSide> sides = sorted_sides(mesh);
  std::erase_if(sides, [&](const EdgeSide& side) { return faces[side.triangle] == Face::kLeftOut; });
  const auto is_sheet = [&](std::size_t side) { return faces[sides[side].triangle] == Face::kSheet; };
  NumberSets connected(mesh.triangles.cols());
  const auto first_sheet = [&](std::size_t begin, std::size_t end) {
    while (begin < end && !is_sheet(begin)) ++begin;
    return begin;
  };
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    const std::size_t first = first_sheet(begin, end);
    for (std::size_t i = first; i < end; ++i) {
      if (is_sheet(i)) connected.join(sides[first].triangle, sides[i].triangle);
    }
  });
  std::map<int, Patch> patches;
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    const std::size_t first = first_sheet(begin, end);
    if (first == end) return;
    std::size_t sheets = 0;
    for (std::size_t i = begin; i < end; ++i) sheets += is_sheet(i) ? 1 : 0;
    Patch& patch = patches[connected.of(sides[first].triangle)];
    patch.box.extend(mesh.vertices_m.col(sides[first].from)).extend(mesh.vertices_m.col(sides[first].to));
    const std::size_t others = end - begin - sheets;
    if (sheets % 2 == 1 && others > 0) patch.fitting += others % 2 == 1 ? 1 : -1;
  });
  Eigen::AlignedBox3d rest;
  for (Index i = 0; i < mesh.triangles.cols(); ++i) {
    for (int k = 0; k < 3 && faces[i] == Face::kSingle; ++k) rest.extend(mesh.vertices_m.col(mesh.triangles(k, i)));
  }
  for (Index i = 0; i < mesh.triangles.cols(); ++i) {
    if (faces[i] != Face::kSheet) continue;
    const Patch& patch = patches[connected.of(i)];
    const bool is_wall = patch.fitting < 0 || (patch.fitting == 0 && !rest.isEmpty() && rest.contains(patch.box));
    if (is_wall) faces[i] = Face::kLeftOut;
  }
}

}  // namespace

NumberSets::NumberSets(Index count) : above_(count) { std::iota(above_.begin(), above_.end(), 0); }

int NumberSets::of(Index number) {
  auto i = static_cast<int>(number);
  while (above_[i] != i) i = above_[i] = above_[above_[i]];
  return i;
}

bool NumberSets::join(Index a, Index b) {
  const int one = of(a), other = of(b);
  above_[std::max(one, other)] = std::min(one, other);
  return one != other;
}

std::vector<EdgeSide> sorted_sides(const TriangleMesh& mesh) {
  // By the lesser vertex in one pass over all; then the few of each vertex by the greater one.
  std::vector<std::size_t> begin(mesh.vertices_m.cols() + 1, 0);
  const auto for_each_side = [&](const auto& f) {
    for (Index i = 0; i < mesh.triangles.cols(); ++i) {
      for (int k = 0; k < 3; ++k) f(mesh.triangles(k, i), mesh.triangles((k + 1) % 3, i), i);
    }
  };
  for_each_side([&](int a, int b, Index) { ++begin[std::min(a, b) + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<EdgeSide> sides(3 * mesh.triangles.cols());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for_each_side([&](int a, int b, Index i) {
    sides[next[std::min(a, b)]++] = {std::min(a, b), std::max(a, b), a < b ? 1 : -1, i};
  });
  for (std::size_t vertex = 0; vertex + 1 < begin.size(); ++vertex) {
    std::sort(sides.begin() + static_cast<std::ptrdiff_t>(begin[vertex]),
              sides.begin() + static_cast<std::ptrdiff_t>(begin[vertex + 1]), [](const EdgeSide& a, const EdgeSide& b) {
                return a.to != b.to ? a.to < b.to : a.triangle < b.triangle;
              });
  }
  return sides;
}

Index remove_doubled_faces(TriangleMesh& mesh, std::vector<EdgeSide>& sides) {
  if (!may_have_doubled(mesh, sides)) return 0;
  cut_alike(mesh, sides);
  std::vector<Face> faces = mark_doubled(mesh);
  if (std::ranges::find(faces, Face::kSheet) != faces.end()) mark_walls(mesh, faces);
  Index kept = 0;
  for (Index i = 0; i < mesh.triangles.cols(); ++i) {
    if (faces[i] != Face::kLeftOut) mesh.triangles.col(kept++) = mesh.triangles.col(i);
  }
  const Index removed = mesh.triangles.cols() - kept;
  mesh.triangles.conservativeResize(3, kept);
  sides = sorted_sides(mesh);
  return removed;
}

std::vector<MeshRim> close_rims(TriangleMesh& mesh) {
  const std::vector<EdgeSide> sides = sorted_sides(mesh);
  std::vector<EdgeSide> open;
  NumberSets connected(mesh.vertices_m.cols());
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    int along = 0;
    for (std::size_t i = begin; i < end; ++i) along += sides[i].along;
    if (along == 0) return;
    open.push_back(sides[begin]);
    open.back().along = along;
    connected.join(sides[begin].from, sides[begin].to);
  });
  struct Sum {
    Vector3d points_m = Vector3d::Zero(), area_m2 = Vector3d::Zero();
    double count = 0.0;
    int vertex = 0;
  };
  std::map<int, Sum> rims;
  for (const EdgeSide& run : open) {
    Sum& rim = rims[connected.of(run.from)];
    rim.points_m += mesh.vertices_m.col(run.from) + mesh.vertices_m.col(run.to);
    rim.count += 2.0;
  }
  const Index vertices = mesh.vertices_m.cols();
  mesh.vertices_m.conservativeResize(3, vertices + std::ssize(rims));
  int next = static_cast<int>(vertices);
  for (auto& [root, rim] : rims) {
    rim.vertex = next++;
    mesh.vertices_m.col(rim.vertex) = rim.points_m / rim.count;
  }
  std::vector<int> caps;
  for (const EdgeSide& run : open) {
    Sum& rim = rims[connected.of(run.from)];
    const Vector3d m = mesh.vertices_m.col(rim.vertex);
    const Vector3d a = mesh.vertices_m.col(run.from) - m, b = mesh.vertices_m.col(run.to) - m;
    rim.area_m2 += 0.5 * run.along * a.cross(b);
    const int from = run.along > 0 ? run.to : run.from, to = run.along > 0 ? run.from : run.to;
    for (int k = 0; k < std::abs(run.along); ++k) caps.insert(caps.end(), {from, to, rim.vertex});
  }
  const Index triangles = mesh.triangles.cols();
  mesh.triangles.conservativeResize(3, triangles + std::ssize(caps) / 3);
  mesh.triangles.rightCols(std::ssize(caps) / 3) = Eigen::Map<Eigen::Matrix3Xi>(caps.data(), 3, std::ssize(caps) / 3);
  std::vector<MeshRim> found;
  for (const auto& [root, rim] : rims) found.push_back({rim.points_m / rim.count, rim.area_m2.norm()});
  return found;
}

bool has_several_parts(const TriangleMesh& mesh) {
  const std::vector<EdgeSide> sides = sorted_sides(mesh);
  NumberSets connected(mesh.triangles.cols());
  bool is_branched = false;
  Index parts = mesh.triangles.cols();
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    is_branched = is_branched || end - begin > 2;
    if (end - begin != 2) return;
    if (connected.join(sides[begin].triangle, sides[begin + 1].triangle)) --parts;
  });
  return is_branched || parts > 1;
}

}  // namespace thenar
