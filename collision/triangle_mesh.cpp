// SPDX-License-Identifier: Apache-2.0
#include "collision/triangle_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "collision/blue_noise.h"
#include "collision/joined_vertices.h"
#include "collision/mesh_edges.h"
#include "collision/split_edges.h"
#include "collision/winding_number.h"

namespace thenar {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Index;
using Eigen::Vector3d;

/// Returns twice a triangle's area times its normal.
Vector3d area_vector(const TriangleMesh& mesh, Index triangle) {
  const auto corner = [&](int k) { return mesh.vertices_m.col(mesh.triangles(k, triangle)); };
  return Vector3d(corner(1) - corner(0)).cross(Vector3d(corner(2) - corner(0)));
}

/// Returns the angle of a triangle at one of its corners.
double angle_at(const TriangleMesh& mesh, Index triangle, int corner) {
  const auto place = [&](int k) { return mesh.vertices_m.col(mesh.triangles((corner + k) % 3, triangle)); };
  const Vector3d a = place(1) - place(0), b = place(2) - place(0);
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Triangles around a vertex that are looked at, each from each: more meet in hubs of fans, each as narrow as half a
// degree, which have the normals of their own.
constexpr Index kMostAround = 1000;

/// Computes normals at the corners of triangles, three per triangle: the mean of those that meet there, weighted by
/// their angles and areas, so that a large flat face stays flat beside the small ones of a fillet. Triangles at more
/// than 20 degrees from the triangle itself belong to another face, and do not count.
std::vector<std::array<Vector3d, 3>> corner_normals(const TriangleMesh& mesh) {
  const double same_face = std::cos(20.0 * std::numbers::pi / 180.0);
  const Index count = mesh.triangles.cols();
  std::vector<Vector3d> own(count), area(count);
  std::vector<Index> begin(mesh.vertices_m.cols() + 1, 0);
  for (Index i = 0; i < count; ++i) {
    area[i] = area_vector(mesh, i);
    own[i] = area[i].stableNormalized();
    for (int k = 0; k < 3; ++k) ++begin[mesh.triangles(k, i) + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::pair<Index, double>> around(3 * count);  // of each vertex, its triangles and their angles there
  std::vector<Index> next(begin.begin(), begin.end() - 1);
  for (Index i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) around[next[mesh.triangles(k, i)]++] = {i, angle_at(mesh, i, k)};
  }
  std::vector<std::array<Vector3d, 3>> normals(count);
  for (Index i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) {
      const int vertex = mesh.triangles(k, i);
      if (begin[vertex + 1] - begin[vertex] > kMostAround) {
        normals[i][k] = own[i];
        continue;
      }
      Vector3d sum = Vector3d::Zero();
      for (Index at = begin[vertex]; at < begin[vertex + 1]; ++at) {
        const auto [triangle, angle] = around[at];
        if (own[triangle].dot(own[i]) > same_face) sum += angle * area[triangle];
      }
      normals[i][k] = sum.stableNormalized();
    }
  }
  return normals;
}

/// The size of the box of all vertices that triangles have [m]; 0 if it is beyond the range of numbers.
double size_m(const TriangleMesh& mesh) {
  AlignedBox3d box;
  for (const int vertex : mesh.triangles.reshaped()) box.extend(mesh.vertices_m.col(vertex));
  const double size_m = box.isEmpty() ? 0.0 : box.diagonal().norm();
  return std::isfinite(size_m) ? size_m : 0.0;
}

/// Returns the triangles with the vertices joined that are no further apart.
Eigen::Matrix3Xi joined_triangles(const TriangleMesh& mesh, double apart_m) {
  std::vector<int> used(mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size());
  std::ranges::sort(used);
  used.erase(std::unique(used.begin(), used.end()), used.end());
  const std::vector<int> joined = join_vertices(mesh.vertices_m(Eigen::all, used), apart_m);
  std::vector<int> number(mesh.vertices_m.cols());
  for (std::size_t i = 0; i < used.size(); ++i) number[used[i]] = used[joined[i]];
  Eigen::Matrix3Xi triangles = mesh.triangles;
  for (int& vertex : triangles.reshaped()) vertex = number[vertex];
  return triangles;
}

/// Drops triangles of fewer than three vertices, all if none has area. Returns the number of those without area: three
/// vertices on one line close the gap between the triangles at their sides.
Index drop_without_area(TriangleMesh& mesh) {
  Index kept = 0, flat = 0;
  for (Index i = 0; i < mesh.triangles.cols(); ++i) {
    const Eigen::Vector3i t = mesh.triangles.col(i);
    const Vector3d area = area_vector(mesh, i);
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0] || !area.allFinite()) continue;
    if (area.isZero(0.0)) ++flat;
    mesh.triangles.col(kept++) = t;
  }
  if (flat == kept) flat = kept = 0;
  const Index without = mesh.triangles.cols() - kept + flat;
  mesh.triangles.conservativeResize(3, kept);
  return without;
}

Index count_open_edges(const std::vector<EdgeSide>& sides) {
  Index open = 0;
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) { open += end - begin == 1 ? 1 : 0; });
  return open;
}

// What a program computes as zero is some 1e-18 of the size; numbers of single precision, or of seven digits, are off
// by some 1e-7 of it. Where joining the former leaves a closed surface, the latter are not joined.
constexpr double kNear = 1e-9, kFar = 1e-6;

/// Joins vertices in one place, and drops what has no area then. Returns the sides that are left.
std::vector<EdgeSide> join(TriangleMesh& mesh, double whole_m, MeshMending& mending) {
  TriangleMesh far{{}, mesh.triangles};
  mesh.triangles = joined_triangles(mesh, kNear * whole_m);
  mending.dropped = drop_without_area(mesh);
  std::vector<EdgeSide> sides = sorted_sides(mesh);
  const Index open = count_open_edges(sides);
  if (open == 0) return sides;
  far.vertices_m = mesh.vertices_m;
  far.triangles = joined_triangles(far, kFar * whole_m);
  const Index dropped = drop_without_area(far);
  std::vector<EdgeSide> far_sides = sorted_sides(far);
  if (count_open_edges(far_sides) >= open) return sides;
  mesh = std::move(far);
  mending.dropped = dropped;
  mending.joined_m = kFar * whole_m;
  return far_sides;
}

/// Two triangles that share an edge with no other.
struct Neighbours {
  Index a, b;
  bool agree;  ///< They run along the edge in opposite ways.
};

std::vector<Neighbours> find_neighbours(const std::vector<EdgeSide>& sides, MeshMending& mending) {
  std::vector<Neighbours> neighbours;
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    ++mending.edges;
    if (end - begin == 1) ++mending.open_edges;
    if (end - begin != 2) return;
    const EdgeSide &a = sides[begin], &b = sides[begin + 1];
    neighbours.push_back({a.triangle, b.triangle, a.along != b.along});
  });
  return neighbours;
}

/// The neighbours of triangle i are links[begin[i] .. begin[i + 1]).
struct Adjacency {
  struct Link {
    Index triangle;
    bool agree;
  };
  std::vector<std::size_t> begin;
  std::vector<Link> links;
};

Adjacency adjacency_of(const std::vector<Neighbours>& neighbours, Index triangles) {
  Adjacency adjacency{std::vector<std::size_t>(triangles + 1, 0), std::vector<Adjacency::Link>(2 * neighbours.size())};
  for (const Neighbours& pair : neighbours) {
    ++adjacency.begin[pair.a + 1];
    ++adjacency.begin[pair.b + 1];
  }
  std::partial_sum(adjacency.begin.begin(), adjacency.begin.end(), adjacency.begin.begin());
  std::vector<std::size_t> next(adjacency.begin.begin(), adjacency.begin.end() - 1);
  for (const Neighbours& pair : neighbours) {
    adjacency.links[next[pair.a]++] = {pair.b, pair.agree};
    adjacency.links[next[pair.b]++] = {pair.a, pair.agree};
  }
  return adjacency;
}

/// A connected part of a mesh.
struct Part {
  std::vector<Index> triangles;
  double volume_m3 = 0.0;  ///< Signed: negative if it is inside out.
  AlignedBox3d bounds;
};

/// Orients the part of `seed` like its majority, as far as its triangles agree, and marks them as `seen`.
Part wind_part(const Adjacency& adjacency, Index seed, std::vector<char>& seen, std::vector<char>& turned) {
  Part part;
  part.triangles.push_back(seed);
  seen[seed] = 1;
  for (std::size_t next = 0; next < part.triangles.size(); ++next) {
    const Index i = part.triangles[next];
    for (std::size_t k = adjacency.begin[i]; k < adjacency.begin[i + 1]; ++k) {
      const auto [other, agree] = adjacency.links[k];
      if (seen[other] != 0) continue;
      seen[other] = 1;
      turned[other] = agree ? turned[i] : static_cast<char>(1 - turned[i]);
      part.triangles.push_back(other);
    }
  }
  const auto count = std::ranges::count_if(part.triangles, [&](Index i) { return turned[i] != 0; });
  if (2 * count > std::ssize(part.triangles)) {
    for (const Index i : part.triangles) turned[i] = static_cast<char>(1 - turned[i]);
  }
  return part;
}

void measure(const TriangleMesh& mesh, const std::vector<char>& turned, Part& part) {
  for (const Index i : part.triangles) {
    for (int k = 0; k < 3; ++k) part.bounds.extend(mesh.vertices_m.col(mesh.triangles(k, i)));
  }
  // Tetrahedra to the middle of the part, so that an open part's volume does not depend on where it is.
  const Vector3d middle = part.bounds.center();
  for (const Index i : part.triangles) {
    const double volume = (mesh.vertices_m.col(mesh.triangles(0, i)) - middle).dot(area_vector(mesh, i)) / 6.0;
    part.volume_m3 += turned[i] != 0 ? -volume : volume;
  }
}

/// Puts parts together that only close one another: at an edge of several, where triangles run equally often both ways,
/// but not those of the part. Such are the walls of two solids that touch, where the wall between them is left out.
void put_together(const std::vector<EdgeSide>& sides, const std::vector<char>& turned, std::vector<Part>& parts) {
  std::vector<int> part_of(turned.size());
  for (std::size_t k = 0; k < parts.size(); ++k) {
    for (const Index i : parts[k].triangles) part_of[i] = static_cast<int>(k);
  }
  NumberSets together(std::ssize(parts));
  bool is_any = false;
  for_each_edge(sides, [&](std::size_t begin, std::size_t end) {
    if (end - begin <= 2) return;
    std::vector<std::pair<int, int>> runs;  // of each side, its part and its direction
    int along = 0;
    for (std::size_t i = begin; i < end; ++i) {
      runs.emplace_back(part_of[sides[i].triangle], turned[sides[i].triangle] != 0 ? -sides[i].along : sides[i].along);
      along += runs.back().second;
    }
    if (along != 0) return;
    std::ranges::sort(runs);
    int open = -1;
    for (std::size_t i = 0; i < runs.size();) {
      const int part = runs[i].first;
      int own = 0;
      for (; i < runs.size() && runs[i].first == part; ++i) own += runs[i].second;
      if (own == 0) continue;
      if (open >= 0) is_any = together.join(open, part) || is_any;
      open = part;
    }
  });
  if (!is_any) return;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    std::vector<Index>& all = parts[together.of(static_cast<Index>(k))].triangles;
    if (&all == &parts[k].triangles) continue;
    all.insert(all.end(), parts[k].triangles.begin(), parts[k].triangles.end());
    parts[k].triangles.clear();
  }
  std::erase_if(parts, [](const Part& part) { return part.triangles.empty(); });
}

/// Tests whether an inside-out part may be the cavity of a solid one: of one of the `largest`.
bool is_cavity(const Part& part, const std::vector<const Part*>& largest) {
  return std::ranges::any_of(largest, [&](const Part* other) {
    return other != &part && other->volume_m3 > std::abs(part.volume_m3) && other->bounds.contains(part.bounds);
  });
}

/// Reverses what is inside out: all, if the whole is; parts that are no cavities.
void reverse_parts(std::vector<Part>& parts, std::vector<char>& turned) {
  // A file that is inside out as a whole is reversed as a whole, with its cavities.
  const double whole_m3 = std::accumulate(parts.begin(), parts.end(), 0.0,
                                          [](double sum, const Part& part) { return sum + part.volume_m3; });
  if (whole_m3 < 0.0) {
    for (char& side : turned) side = static_cast<char>(1 - side);
    for (Part& part : parts) part.volume_m3 *= -1.0;
  }
  constexpr std::size_t kMost = 1000;  // Solids with cavities, which are looked at for each part.
  std::vector<const Part*> largest;
  for (const Part& part : parts) largest.push_back(&part);
  std::ranges::stable_sort(largest, std::greater<>(), [](const Part* part) { return part->volume_m3; });
  if (largest.size() > kMost) largest.resize(kMost);
  for (const Part& part : parts) {
    if (part.volume_m3 >= 0.0 || is_cavity(part, largest)) continue;
    for (const Index i : part.triangles) turned[i] = static_cast<char>(1 - turned[i]);
  }
}

/// Tests whether the corner of a polygon between a and c, with the remaining corners `others`, can be cut off: it is
/// convex along the normal n, and no other corner lies in the triangle.
bool is_ear(const Eigen::Matrix3Xd& corners, int a, int b, int c, const std::vector<int>& others, const Vector3d& n) {
  const auto side = [&](int from, int to, int third) {
    const Vector3d edge = corners.col(to) - corners.col(from);
    return n.dot(edge.cross(Vector3d(corners.col(third) - corners.col(from))));
  };
  if (side(a, b, c) <= 0.0) return false;
  return std::ranges::none_of(others, [&](int p) {
    // A bridge to a hole runs along its places twice.
    for (const int own : {a, b, c}) {
      if (corners.col(p) == corners.col(own)) return false;
    }
    return side(a, b, p) >= 0.0 && side(b, c, p) >= 0.0 && side(c, a, p) >= 0.0;
  });
}

}  // namespace

std::vector<Eigen::Vector3i> cut_polygon(const Eigen::Matrix3Xd& corners) {
  std::vector<int> left(corners.cols());
  std::iota(left.begin(), left.end(), 0);
  if (left.size() == 3) return {{0, 1, 2}};
  // Newell's normal, which corners out of the plane do not upset.
  Vector3d n = Vector3d::Zero();
  for (Index i = 0; i < corners.cols(); ++i) {
    const Vector3d a = corners.col(i) - corners.col(0), b = corners.col((i + 1) % corners.cols()) - corners.col(0);
    n += a.cross(b);
  }
  std::vector<Eigen::Vector3i> triangles;
  // Ears are cut off [Meisters 1975] until none is left; whole turns without one end it. A cut changes the corners
  // beside it: the others, once found to be none, are looked at again where no other is left, which a few times is of
  // use in polygons with corners on one line.
  std::vector<char> is_none(left.size(), 0);
  int looks = 8;
  for (std::size_t at = 0, without = 0; left.size() >= 3;) {
    const std::size_t size = left.size();
    if (without == size) {
      if (looks-- == 0 || size == 3) break;
      std::ranges::fill(is_none, 0);
      without = 0;
    }
    at %= size;
    const int a = left[(at + size - 1) % size], b = left[at], c = left[(at + 1) % size];
    if (size > 3 && (is_none[b] != 0 || !is_ear(corners, a, b, c, left, n))) {
      is_none[b] = 1;
      ++at;
      ++without;
      continue;
    }
    triangles.emplace_back(a, b, c);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
    is_none[a] = is_none[c] = 0;
    without = 0;
  }
  return triangles;
}

MeshMending mend(TriangleMesh& mesh) {
  MeshMending mending;
  const double whole_m = size_m(mesh);
  std::vector<EdgeSide> sides = join(mesh, whole_m, mending);
  mending.split = split_open_edges(mesh, sides, kFar * whole_m);
  mending.doubled = remove_doubled_faces(mesh, sides);
  const Index count = mesh.triangles.cols();
  const std::vector<Neighbours> neighbours = find_neighbours(sides, mending);
  const Adjacency adjacency = adjacency_of(neighbours, count);

  std::vector<char> seen(count, 0), turned(count, 0);
  std::vector<Part> parts;
  for (Index i = 0; i < count; ++i) {
    if (seen[i] == 0) parts.push_back(wind_part(adjacency, i, seen, turned));
  }
  for (const Neighbours& pair : neighbours) {
    if (pair.agree != (turned[pair.a] == turned[pair.b])) ++mending.at_odds;
  }
  put_together(sides, turned, parts);
  for (Part& part : parts) measure(mesh, turned, part);
  reverse_parts(parts, turned);
  for (Index i = 0; i < count; ++i) {
    if (turned[i] == 0) continue;
    ++mending.turned;
    std::swap(mesh.triangles(1, i), mesh.triangles(2, i));
  }
  return mending;
}

PointCloud sample_mesh(const TriangleMesh& mesh, Index count, std::uint32_t seed, double* covered) {
  std::vector<double> areas_m2(mesh.triangles.cols());
  for (Index i = 0; i < mesh.triangles.cols(); ++i) areas_m2[i] = 0.5 * area_vector(mesh, i).norm();
  const double area_m2 = std::accumulate(areas_m2.begin(), areas_m2.end(), 0.0);
  if (!(area_m2 > 0.0) || !std::isfinite(area_m2)) throw std::invalid_argument("the triangles have no area");
  const std::vector<std::array<Vector3d, 3>> normals = corner_normals(mesh);
  std::optional<WindingNumber> solids;
  if (covered != nullptr && has_several_parts(mesh)) solids.emplace(mesh);
  // Solids touch across a gap that no finger can feel: convex parts that approximate a solid leave some.
  const double touch_m = 1e-3 * size_m(mesh);
  Index inside = 0, drawn = 0;
  const auto draw = [&](Index triangle, Uniform& uniform) -> std::optional<SurfaceSample> {
    // The unit square folded along its diagonal.
    double s = uniform(), t = uniform();
    if (s + t > 1.0) {
      s = 1.0 - s;
      t = 1.0 - t;
    }
    const Vector3d a = mesh.vertices_m.col(mesh.triangles(0, triangle));
    const Vector3d b = mesh.vertices_m.col(mesh.triangles(1, triangle));
    const Vector3d c = mesh.vertices_m.col(mesh.triangles(2, triangle));
    const auto& [n_a, n_b, n_c] = normals[triangle];
    const Vector3d p = a + s * (b - a) + t * (c - a);
    ++drawn;
    if (solids && (*solids)(p + touch_m * area_vector(mesh, triangle).stableNormalized()) > 0.5) {
      ++inside;
      return std::nullopt;
    }
    return SurfaceSample{p, ((1.0 - s - t) * n_a + s * n_b + t * n_c).normalized()};
  };
  PointCloud cloud = sample_blue_noise(areas_m2, count, seed, draw);
  if (covered != nullptr) *covered = static_cast<double>(inside) / static_cast<double>(drawn);
  return cloud;
}

}  // namespace thenar
