#include "collision/blue_noise.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <stdexcept>
#include <utility>

#include "collision/point_grid.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;

// Candidates for every sample kept: beyond 5 the result hardly improves and the time still grows [Yuksel 2015].
constexpr Index kCandidatesPerSample = 5;

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

PointCloud sample_blue_noise(const std::vector<double>& areas_m2, Index count, std::uint32_t seed,
                             const DrawSample& draw) {
  if (count < 1) throw std::invalid_argument("the number of samples must be at least 1");
  std::vector<double> area_until_m2(areas_m2.size());
  double area_m2 = 0.0;
  for (std::size_t piece = 0; piece < areas_m2.size(); ++piece) area_until_m2[piece] = area_m2 += areas_m2[piece];

  Uniform uniform(seed);
  const Index all = kCandidatesPerSample * count;
  PointCloud candidates{Matrix3Xd(3, all), Matrix3Xd(3, all)};
  Index drawn = 0;
  std::size_t piece = 0;
  for (Index i = 0; i < all; ++i) {
    // Even steps through the summed area give every piece its share, where drawing the piece would add noise.
    const double at_m2 = area_m2 * (static_cast<double>(i) + 0.5) / static_cast<double>(all);
    while (piece + 1 < area_until_m2.size() && at_m2 > area_until_m2[piece]) ++piece;
    const auto sample = draw(static_cast<Index>(piece), uniform);
    if (!sample) continue;
    candidates.points_m.col(drawn) = sample->point_m;
    candidates.normals.col(drawn++) = sample->normal;
  }
  if (drawn < count) throw std::invalid_argument("too little of the surface is free");
  candidates.points_m.conservativeResize(3, drawn);
  candidates.normals.conservativeResize(3, drawn);
  return eliminate(candidates, area_m2 * static_cast<double>(drawn) / static_cast<double>(all), count);
}

}  // namespace thenar
