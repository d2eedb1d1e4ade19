// SPDX-License-Identifier: Apache-2.0
#include "collision/point_cloud.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace thenar {

using Eigen::Index;

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

}  // namespace thenar
