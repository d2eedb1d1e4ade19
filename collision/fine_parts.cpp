// SPDX-License-Identifier: Apache-2.0
#include "collision/fine_parts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/point_grid.h"

namespace thenar {

using Eigen::Index;

namespace {

constexpr double kLikeNormals = 0.5;  // 60 degrees
constexpr double kWideShare = 0.42;   // At a straight edge a face covers half a disc; a rim of half its radius a third.
constexpr double kSamplesADisc = 40.0;  // Number that distinguishes the two.

}  // namespace

std::vector<Index> fine_parts(const PointCloud& cloud, double control_spacing_m) {
  const double spacing_m = sample_spacing_m(cloud);
  const double radius_m = std::max(control_spacing_m, 2.5 * spacing_m);
  const double in_disc = std::numbers::pi * std::pow(radius_m / spacing_m, 2);
  const auto stride = std::max<Index>(1, static_cast<Index>(in_disc / kSamplesADisc));
  // All samples are counted, and evaluated at a stride: counts at a stride may differ between the two sides of a plate.
  const PointGrid grid(cloud.points_m, radius_m);
  const Index n = cloud.points_m.cols();
  const auto is_like = [&](Index i, Index j) { return cloud.normals.col(i).dot(cloud.normals.col(j)) > kLikeNormals; };

  std::vector<bool> wide(n);
  for (Index i = 0; i < n; i += stride) {
    int like = 1;
    grid.for_each_neighbour(i, [&](Index j, double) { like += is_like(i, j) ? 1 : 0; });
    wide[i] = like > kWideShare * in_disc;
  }
  std::vector<Index> fine;
  for (Index i = 0; i < n; i += stride) {
    bool beside_wide = wide[i];
    if (!beside_wide) grid.for_each_neighbour(i, [&](Index j, double) { beside_wide |= wide[j] && is_like(i, j); });
    if (!beside_wide) fine.push_back(i);
  }
  return fine;
}

}  // namespace thenar
