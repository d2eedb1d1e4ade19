// SPDX-License-Identifier: Apache-2.0
#include "collision/blue_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "collision/point_grid.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;

// Candidates for every sample kept: beyond 5 the result hardly improves and the time still grows [Yuksel 2015].
constexpr Index kCandidatesPerSample = 5;

// The crowding of eliminated samples: below any, whatever is subtracted.
constexpr double kRemoved = -std::numeric_limits<double>::infinity();

/// Replaces a heap's largest entry.
template <typename Entry>
void replace_top(std::vector<Entry>& heap, const Entry& by) {
  std::size_t at = 0;
  for (std::size_t child = 1; child < heap.size(); child = 2 * at + 1) {
    if (child + 1 < heap.size() && heap[child] < heap[child + 1]) ++child;
    if (!(by < heap[child])) break;
    heap[at] = heap[child];
    at = child;
  }
  heap[at] = by;
}

/// Returns the kept samples of a cloud, `count` in number.
PointCloud only(const std::vector<char>& kept, const PointCloud& all, Index count) {
  PointCloud cloud{Matrix3Xd(3, count), Matrix3Xd(3, count)};
  for (Index i = 0, k = 0; i < all.points_m.cols(); ++i) {
    if (kept[i] == 0) continue;
    cloud.points_m.col(k) = all.points_m.col(i);
    cloud.normals.col(k++) = all.normals.col(i);
  }
  return cloud;
}

/// Thins the drawn samples to `count` by repeatedly removing the one most crowded by the others
/// [Yuksel 2015, Sample Elimination for Generating Poisson Disk Sample Sets]. Crowding of i:
///     sum over j of (1 - d_ij / 2 r_max)^8,   r_max = sqrt(area / (2 sqrt(3) count)),
/// where 2 r_max is the distance between samples in the densest (hexagonal) packing.
PointCloud eliminate(const PointCloud& drawn, double area_m2, Index count) {
  const Index all = drawn.points_m.cols();
  const double packing_m = 2.0 * std::sqrt(area_m2 / (2.0 * std::sqrt(3.0) * static_cast<double>(count)));
  // Weight limiting [Yuksel 2015, eq. (6)]: pairs closer than this are equally bad, which keeps clusters from
  // deciding the order.
  const double least_m =
      packing_m * 0.65 * (1.0 - std::pow(static_cast<double>(count) / static_cast<double>(all), 1.5));

  // Neighbours side by side in memory: drawn samples are scattered over the surface.
  const std::vector<Index> order = PointGrid(drawn.points_m, packing_m).members();
  const PointCloud candidates{drawn.points_m(Eigen::all, order), drawn.normals(Eigen::all, order)};
  const PointGrid grid(candidates.points_m, packing_m);
  const auto crowding = [&](Index i, Index j, double distance_m) {
    // The two sides of a plate are two surfaces: they do not crowd each other.
    if (candidates.normals.col(i).dot(candidates.normals.col(j)) < -0.5) return 0.0;
    const double closeness = 1.0 - std::max(distance_m, least_m) / packing_m;
    const double squared = closeness * closeness;
    return squared * squared * squared * squared;
  };
  std::vector<double> crowd(all, 0.0);
  for (Index i = 0; i < all; ++i) {
    grid.for_each_neighbour(i, [&](Index j, double d) { crowd[i] += crowding(i, j, d); });
  }

  // Crowding only ever falls, so what a group's most crowded was is an upper bound: it is refreshed when it comes to
  // the top of a heap. Ties by the order of drawing.
  struct Entry {
    double crowd;
    Index drawn, at;
    bool operator<(const Entry& other) const { return std::tie(crowd, drawn) < std::tie(other.crowd, other.drawn); }
  };
  constexpr Index kGroup = 32;
  const auto most_crowded = [&](Index group) {
    Entry most{crowd[kGroup * group], order[kGroup * group], kGroup * group};
    for (Index i = most.at + 1; i < std::min(all, kGroup * (group + 1)); ++i) {
      if (crowd[i] >= most.crowd) most = std::max(most, {crowd[i], order[i], i});
    }
    return most;
  };
  std::vector<Entry> heap;
  for (Index group = 0; kGroup * group < all; ++group) heap.push_back(most_crowded(group));
  std::make_heap(heap.begin(), heap.end());
  for (Index left = all; left > count;) {
    const Entry bound = heap.front(), top = most_crowded(bound.at / kGroup);
    if (top < bound) {
      replace_top(heap, top);
      continue;
    }
    crowd[top.at] = kRemoved;
    --left;
    grid.for_each_neighbour(top.at, [&](Index j, double d) { crowd[j] -= crowding(top.at, j, d); });
  }

  std::vector<char> kept(all);  // in the order of drawing
  for (Index i = 0; i < all; ++i) kept[order[i]] = crowd[i] != kRemoved;
  return only(kept, drawn, count);
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
  if (drawn < count)
    throw std::invalid_argument(
        "nearly all of the surface lies inside of others: unite its parts into one closed surface");
  candidates.points_m.conservativeResize(3, drawn);
  candidates.normals.conservativeResize(3, drawn);
  return eliminate(candidates, area_m2 * static_cast<double>(drawn) / static_cast<double>(all), count);
}

}  // namespace thenar
