#include "collision/triangle_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "collision/blue_noise.h"

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

/// Merges the indices of coincident vertices to the least of theirs.
void join_vertices(TriangleMesh& mesh) {
  const auto place = [&](int i) {
    return std::make_tuple(mesh.vertices_m(0, i), mesh.vertices_m(1, i), mesh.vertices_m(2, i));
  };
  std::vector<int> order(mesh.vertices_m.cols());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int i) { return std::make_tuple(place(i), i); });
  std::vector<int> number(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool is_same = k > 0 && place(order[k]) == place(order[k - 1]);
    number[order[k]] = is_same ? number[order[k - 1]] : order[k];
  }
  for (int& vertex : mesh.triangles.reshaped()) vertex = number[vertex];
}

Index drop_without_area(TriangleMesh& mesh) {
  Index kept = 0;
  for (Index i = 0; i < mesh.triangles.cols(); ++i) {
    const Vector3d area = area_vector(mesh, i);
    if (area.isZero(0.0) || !area.allFinite()) continue;
    mesh.triangles.col(kept++) = mesh.triangles.col(i);
  }
  const Index dropped = mesh.triangles.cols() - kept;
  mesh.triangles.conservativeResize(3, kept);
  return dropped;
}

/// One side of a triangle.
struct Side {
  int from, to;  ///< The edge, from the lesser vertex to the greater.
  bool forward;  ///< Whether the triangle runs along it that way.
  Index triangle;
};

/// Two triangles that share an edge with no other.
struct Neighbours {
  Index a, b;
  bool agree;  ///< They run along the edge in opposite ways.
};

std::vector<Neighbours> find_neighbours(const TriangleMesh& mesh, MeshMending& mending) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.cols());
  for (Index i = 0; i < mesh.triangles.cols(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int from = mesh.triangles(k, i), to = mesh.triangles((k + 1) % 3, i);
      sides.push_back({std::min(from, to), std::max(from, to), from < to, i});
    }
  }
  std::ranges::sort(sides, {}, [](const Side& side) { return std::make_tuple(side.from, side.to, side.triangle); });
  std::vector<Neighbours> neighbours;
  for (std::size_t first = 0; first < sides.size();) {
    std::size_t end = first + 1;
    while (end < sides.size() && sides[end].from == sides[first].from && sides[end].to == sides[first].to) ++end;
    ++mending.edges;
    if (end - first == 1) ++mending.open_edges;
    if (end - first == 2) {
      const Side &a = sides[first], &b = sides[first + 1];
      neighbours.push_back({a.triangle, b.triangle, a.forward != b.forward});
    }
    first = end;
  }
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

/// Tests whether an inside-out part may be the cavity of a solid one.
bool is_cavity(const Part& part, const std::vector<Part>& parts) {
  return std::ranges::any_of(parts, [&](const Part& other) {
    return &other != &part && other.volume_m3 > std::abs(part.volume_m3) && other.bounds.contains(part.bounds);
  });
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
  // Ears are cut off [Meisters 1975] until none is left; whole turns without one end it.
  for (std::size_t at = 0, without = 0; left.size() >= 3 && without < left.size();) {
    const std::size_t size = left.size();
    at %= size;
    const int a = left[(at + size - 1) % size], b = left[at], c = left[(at + 1) % size];
    if (size > 3 && !is_ear(corners, a, b, c, left, n)) {
      ++at;
      ++without;
      continue;
    }
    triangles.emplace_back(a, b, c);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
    without = 0;
  }
  return triangles;
}

MeshMending mend(TriangleMesh& mesh) {
  MeshMending mending;
  join_vertices(mesh);
  mending.dropped = drop_without_area(mesh);
  const Index count = mesh.triangles.cols();
  const std::vector<Neighbours> neighbours = find_neighbours(mesh, mending);
  const Adjacency adjacency = adjacency_of(neighbours, count);

  std::vector<char> seen(count, 0), turned(count, 0);
  std::vector<Part> parts;
  for (Index i = 0; i < count; ++i) {
    if (seen[i] == 0) parts.push_back(wind_part(adjacency, i, seen, turned));
  }
  for (const Neighbours& pair : neighbours) {
    if (pair.agree != (turned[pair.a] == turned[pair.b])) ++mending.at_odds;
  }
  for (Part& part : parts) measure(mesh, turned, part);
  // A file that is inside out as a whole is reversed as a whole, with its cavities.
  const double whole_m3 = std::accumulate(parts.begin(), parts.end(), 0.0,
                                          [](double sum, const Part& part) { return sum + part.volume_m3; });
  if (whole_m3 < 0.0) {
    for (char& side : turned) side = static_cast<char>(1 - side);
    for (Part& part : parts) part.volume_m3 *= -1.0;
  }
  for (const Part& part : parts) {
    if (part.volume_m3 >= 0.0 || is_cavity(part, parts)) continue;
    for (const Index i : part.triangles) turned[i] = static_cast<char>(1 - turned[i]);
  }
  for (Index i = 0; i < count; ++i) {
    if (turned[i] == 0) continue;
    ++mending.turned;
    std::swap(mesh.triangles(1, i), mesh.triangles(2, i));
  }
  return mending;
}

PointCloud sample_mesh(const TriangleMesh& mesh, Index count, std::uint32_t seed) {
  std::vector<double> areas_m2(mesh.triangles.cols());
  for (Index i = 0; i < mesh.triangles.cols(); ++i) areas_m2[i] = 0.5 * area_vector(mesh, i).norm();
  const double area_m2 = std::accumulate(areas_m2.begin(), areas_m2.end(), 0.0);
  if (!(area_m2 > 0.0) || !std::isfinite(area_m2)) throw std::invalid_argument("the triangles have no area");
  const std::vector<std::array<Vector3d, 3>> normals = corner_normals(mesh);
  return sample_blue_noise(areas_m2, count, seed, [&](Index triangle, Uniform& uniform) {
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
    return SurfaceSample{a + s * (b - a) + t * (c - a), ((1.0 - s - t) * n_a + s * n_b + t * n_c).normalized()};
  });
}

}  // namespace thenar
