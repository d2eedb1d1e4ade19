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

#include "collision/point_grid.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

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

  const PointGrid grid(candidates.points_m, packing_m);
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

double sample_spacing_m(const PointCloud& cloud) {
  if (cloud.points_m.cols() < 2) throw std::invalid_argument("sample_spacing_m: a single sample has no spacing");
  // The disc to the k-th neighbour holds the sample, k - 1 neighbours and half of the k-th: pi r^2/(k + 1/2) a sample.
  // Eight neighbours average over the first ring and stay local; the median over a subset ignores edges and outliers.
  const Index count = cloud.points_m.cols();
  const Index k = std::min<Index>(8, count - 1);
  const Index subset = std::min<Index>(100, count);
  std::vector<double> spacings_m(subset);
  Eigen::VectorXd squared(count);
  for (Index s = 0; s < subset; ++s) {
    squared = (cloud.points_m.colwise() - cloud.points_m.col(s * count / subset)).colwise().squaredNorm();
    std::nth_element(squared.begin(), squared.begin() + k, squared.end());  // the sample itself is number 0
    spacings_m[s] = std::sqrt(std::numbers::pi * squared[k] / (static_cast<double>(k) + 0.5));
  }
  std::nth_element(spacings_m.begin(), spacings_m.begin() + subset / 2, spacings_m.end());
  return spacings_m[subset / 2];
}

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
