#include "collision/point_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <queue>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::Vector3i;

// Candidates for every sample kept: beyond 5 the result hardly improves and the time still grows [Yuksel 2015].
constexpr Index kCandidatesPerSample = 5;

/// Uniform in [0, 1). std::uniform_real_distribution may differ between standard libraries; this does not.
class Uniform {
 public:
  explicit Uniform(std::uint32_t seed) : bits_(seed) {}
  double operator()() {
    const auto high = static_cast<double>(bits_() >> 5U);  // 27 bits
    const auto low = static_cast<double>(bits_() >> 6U);   // 26 bits: 53 together, a double's precision
    return (high * 0x1p26 + low) * 0x1p-53;
  }

 private:
  std::mt19937 bits_;
};

/// The points sorted into cubic cells no smaller than `radius`: a point's neighbours lie in its 27 cells.
class Grid {
 public:
  Grid(const Matrix3Xd& points, double radius) : points_(points), radius_(radius) {
    low_ = points.rowwise().minCoeff();
    const Vector3d extent = points.rowwise().maxCoeff() - low_;
    // 128 cells an axis bound the memory (2 M cells); denser clouds have fuller cells.
    cell_ = std::max(radius, extent.maxCoeff() / 128.0);
    cells_ = (extent / cell_).cast<int>() + Vector3i::Ones();

    // Counting sort: cell k holds members_[begin_[k] .. begin_[k + 1]).
    begin_.assign(cells_.cast<std::size_t>().prod() + 1, 0);
    for (Index i = 0; i < points.cols(); ++i) ++begin_[cell_of(points.col(i)) + 1];
    for (std::size_t k = 1; k < begin_.size(); ++k) begin_[k] += begin_[k - 1];
    members_.resize(points.cols());
    std::vector<Index> next(begin_.begin(), begin_.end() - 1);
    for (Index i = 0; i < points.cols(); ++i) members_[next[cell_of(points.col(i))]++] = i;
  }

  /// Calls visit(j, distance) for every other point j closer than the radius to point i.
  template <typename Visit>
  void for_each_neighbour(Index i, Visit visit) const {
    const Vector3d p = points_.col(i);
    const Vector3i at = ((p - low_) / cell_).cast<int>();
    const Vector3i from = (at.array() - 1).max(0), to = (at.array() + 1).min(cells_.array() - 1);
    for (int x = from.x(); x <= to.x(); ++x) {
      for (int y = from.y(); y <= to.y(); ++y) {
        // Cells along z are adjacent in memory.
        const Index end = begin_[number(x, y, to.z()) + 1];
        for (Index m = begin_[number(x, y, from.z())]; m < end; ++m) {
          const Index j = members_[m];
          const double squared = (points_.col(j) - p).squaredNorm();
          if (squared < radius_ * radius_ && j != i) visit(j, std::sqrt(squared));
        }
      }
    }
  }

 private:
  [[nodiscard]] Index number(int x, int y, int z) const {
    return (static_cast<Index>(x) * cells_.y() + y) * cells_.z() + z;
  }
  [[nodiscard]] Index cell_of(const Vector3d& p) const {
    const Vector3i at = ((p - low_) / cell_).cast<int>();
    return number(at.x(), at.y(), at.z());
  }

  const Matrix3Xd& points_;
  double radius_, cell_;
  Vector3d low_;
  Vector3i cells_;
  std::vector<Index> begin_, members_;
};

/// Thins `candidates` to `count` samples by removing, again and again, the one most crowded by the others
/// [Yuksel 2015, Sample Elimination for Generating Poisson Disk Sample Sets]. Crowding of i:
///     sum over j of (1 - d_ij / 2 r_max)^8,   r_max = sqrt(area / (2 sqrt(3) count)),
/// where 2 r_max is the distance between samples in the densest (hexagonal) packing.
PointCloud eliminate(const PointCloud& candidates, double area_m2, Index count) {
  const Index all = candidates.points_m.cols();
  const double packing_m = 2.0 * std::sqrt(area_m2 / (2.0 * std::sqrt(3.0) * static_cast<double>(count)));
  // Weight limiting [Yuksel 2015, eq. (6)]: pairs closer than this are equally bad, which keeps clusters from
  // deciding the order.
  const double least_m =
      packing_m * 0.65 * (1.0 - std::pow(static_cast<double>(count) / static_cast<double>(all), 1.5));
  const auto crowding = [&](Index i, Index j, double distance_m) {
    // The two sides of a plate are two surfaces: they do not crowd each other.
    if (candidates.normals.col(i).dot(candidates.normals.col(j)) < -0.5) return 0.0;
    const double closeness = 1.0 - std::max(distance_m, least_m) / packing_m;
    const double squared = closeness * closeness;
    return squared * squared * squared * squared;
  };

  const Grid grid(candidates.points_m, packing_m);
  std::vector<double> crowd(all, 0.0);
  for (Index i = 0; i < all; ++i) {
    grid.for_each_neighbour(i, [&](Index j, double d) { crowd[i] += crowding(i, j, d); });
  }

  // Crowding only ever falls, so an entry of the heap is an upper bound: refresh it when it comes to the top.
  using Entry = std::pair<double, Index>;
  std::vector<Entry> entries(all);
  for (Index i = 0; i < all; ++i) entries[i] = {crowd[i], i};
  std::priority_queue<Entry, std::vector<Entry>, std::less<>> heap(std::less<>(), std::move(entries));
  std::vector<char> kept(all, 1);
  for (Index left = all; left > count;) {
    const Entry top = heap.top();
    const Index i = top.second;
    heap.pop();
    if (top.first > crowd[i]) {
      heap.emplace(crowd[i], i);
      continue;
    }
    kept[i] = 0;
    --left;
    grid.for_each_neighbour(i, [&](Index j, double d) { crowd[j] -= crowding(i, j, d); });
  }

  PointCloud cloud{Matrix3Xd(3, count), Matrix3Xd(3, count)};
  for (Index i = 0, k = 0; i < all; ++i) {
    if (kept[i] == 0) continue;
    cloud.points_m.col(k) = candidates.points_m.col(i);
    cloud.normals.col(k++) = candidates.normals.col(i);
  }
  return cloud;
}

}  // namespace

PointCloud sample_box(const Vector3d& size_m, Index count, std::uint32_t seed) {
  if (!(size_m.minCoeff() > 0.0) || !size_m.allFinite()) {
    throw std::invalid_argument("sample_box: sizes must be finite and greater than zero");
  }
  if (count < 1) throw std::invalid_argument("sample_box: count must be at least 1");

  // The faces one after another: x-, x+, y-, y+, z-, z+.
  std::array<double, 6> area_until_m2;
  double area_m2 = 0.0;
  for (int face = 0; face < 6; ++face) {
    area_m2 += size_m.prod() / size_m[face / 2];
    area_until_m2[face] = area_m2;
  }

  Uniform uniform(seed);
  const Index all = kCandidatesPerSample * count;
  PointCloud candidates{Matrix3Xd(3, all), Matrix3Xd::Zero(3, all)};
  for (Index i = 0; i < all; ++i) {
    // Even steps through the summed area give every face its share, where drawing the face would add noise.
    const double at_m2 = area_m2 * (static_cast<double>(i) + 0.5) / static_cast<double>(all);
    int face = 0;
    while (face < 5 && at_m2 > area_until_m2[face]) ++face;
    const int axis = face / 2;
    const double side = face % 2 == 0 ? -1.0 : 1.0;
    for (int k = 0; k < 3; ++k) candidates.points_m(k, i) = size_m[k] * (uniform() - 0.5);
    candidates.points_m(axis, i) = 0.5 * side * size_m[axis];
    candidates.normals(axis, i) = side;
  }
  return eliminate(candidates, area_m2, count);
}

PointCloud sample_sphere(double radius_m, Index count, std::uint32_t seed) {
  if (!(radius_m > 0.0) || !std::isfinite(radius_m)) {
    throw std::invalid_argument("sample_sphere: the radius must be finite and greater than zero");
  }
  if (count < 1) throw std::invalid_argument("sample_sphere: count must be at least 1");

  Uniform uniform(seed);
  const Index all = kCandidatesPerSample * count;
  PointCloud candidates{Matrix3Xd(3, all), Matrix3Xd(3, all)};
  for (Index i = 0; i < all; ++i) {
    // Archimedes: the area between two heights is proportional to their difference.
    const double z = 2.0 * uniform() - 1.0;
    const double angle = 2.0 * std::numbers::pi * uniform();
    const double r = std::sqrt(1.0 - z * z);
    candidates.normals.col(i) = Vector3d(r * std::cos(angle), r * std::sin(angle), z).normalized();
  }
  candidates.points_m = radius_m * candidates.normals;
  return eliminate(candidates, 4.0 * std::numbers::pi * radius_m * radius_m, count);
}

}  // namespace thenar
