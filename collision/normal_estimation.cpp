// SPDX-License-Identifier: Apache-2.0
#include "collision/normal_estimation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <queue>
#include <stdexcept>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "collision/point_grid.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// The samples around each: within 3 spacings, or, where a scan is sparse, within 2, 4 or 8 times as many.
class LocalSamples {
 public:
  LocalSamples(const PointCloud& cloud, double spacing_m) : spacing_m_(spacing_m), level_(cloud.points_m.cols(), 0) {
    // An even scan has 28 samples around one, and 14 at a rim. Signs need some within 2 spacings.
    constexpr int kFew = 8;
    constexpr std::size_t kLevels = 4;
    grids_.reserve(kLevels);
    for (bool is_sparse = true; is_sparse && grids_.size() < kLevels;) {
      const std::size_t level = grids_.size();
      const PointGrid& grid = grids_.emplace_back(cloud.points_m, 3.0 * spacing_m * std::exp2(level));
      is_sparse = false;
      for (std::size_t i = 0; i < level_.size(); ++i) {
        if (level_[i] != level) continue;
        int around = 0;
        grid.for_each_neighbour(static_cast<Index>(i), [&](Index, double) { ++around; });
        if (around >= kFew || level + 1 == kLevels) continue;
        ++level_[i];
        is_sparse = true;
      }
    }
  }

  /// `spacings` times the spacing, or, around a sparse sample, 2, 4 or 8 times as much.
  [[nodiscard]] double radius_m(Index i, double spacings) const { return spacings * spacing_m_ * std::exp2(level_[i]); }
  [[nodiscard]] bool is_sparse(Index i) const { return level_[i] > 0; }

  /// Calls back with each sample within this radius around sample i, 3 spacings at most, and its distance.
  template <typename See>
  void for_each(Index i, double spacings, const See& see) const {
    const double most_m = radius_m(i, spacings);
    grids_[level_[i]].for_each_neighbour(i, [&](Index j, double distance_m) {
      if (distance_m < most_m) see(j, distance_m);
    });
  }

 private:
  double spacing_m_;
  std::vector<std::size_t> level_;
  std::vector<PointGrid> grids_;
};

/// The plane near a sample.
struct LocalPlane {
  Vector3d normal = Vector3d::UnitZ();  ///< Of either sign.
  bool is_one = false;                  ///< The samples lie along a plane, and not along a line.
};

LocalPlane plane_near(const PointCloud& cloud, const LocalSamples& samples, Index i) {
  const double radius_m = samples.radius_m(i, 3.0);
  LocalPlane plane;
  Vector3d n = Vector3d::Zero();
  // The first plane is that of all neighbours; each next one gives less weight to those far from the last.
  for (int pass = 0; pass < 6; ++pass) {
    // From half the radius down to a tenth.
    const double height_m = radius_m * std::max(0.1, 0.5 * std::pow(0.7, pass - 1));
    Matrix3d moments = Matrix3d::Zero();
    double sum = 0.0;
    samples.for_each(i, 3.0, [&](Index j, double distance_m) {
      const Vector3d step_m = cloud.points_m.col(j) - cloud.points_m.col(i);
      const double height = pass == 0 ? 0.0 : step_m.dot(n) / height_m;
      const double near = 1.0 - distance_m * distance_m / (radius_m * radius_m);
      const double weight = near / ((1.0 + height * height) * (1.0 + height * height));
      sum += weight;
      moments += weight * step_m * step_m.transpose();
    });
    if (!(sum > 0.0)) return {};
    // The plane passes through the sample, which lies on its own face only: through the mean an edge would be cut.
    const auto axes = Eigen::SelfAdjointEigenSolver<Matrix3d>().computeDirect(moments);
    const Vector3d spread = axes.eigenvalues();
    if (pass == 0) plane.is_one = 4.0 * spread[0] < spread[1] && 4.0 * spread[1] > spread[2];
    plane.normal = n = axes.eigenvectors().col(0);
  }
  return plane;
}

/// Returns the normal at the other end of the step if both lie on one arc: n mirrored in the plane across the step.
Vector3d carried(const Vector3d& n, const Vector3d& step_m) {
  return n - 2.0 * n.dot(step_m) / step_m.squaredNorm() * step_m;
}

/// The samples that pass their signs to each: those within 2 spacings of it, and the sparse ones that have it within
/// theirs.
class SignLinks {
 public:
  explicit SignLinks(const LocalSamples& samples, Index count) : samples_(samples) {
    for (Index j = 0; j < count; ++j) {
      if (!samples.is_sparse(j)) continue;
      for_each_near(j, [&](Index i) {
        if (samples.radius_m(i, 2.0) < samples.radius_m(j, 2.0)) sparse_near_[i].push_back(j);
      });
    }
  }

  template <typename See>
  void for_each(Index i, const See& see) const {
    for_each_near(i, see);
    const auto others = sparse_near_.find(i);
    if (others != sparse_near_.end()) std::ranges::for_each(others->second, see);
  }

 private:
  template <typename See>
  void for_each_near(Index i, const See& see) const {
    samples_.for_each(i, 2.0, [&](Index j, double) { see(j); });
  }

  const LocalSamples& samples_;
  std::unordered_map<Index, std::vector<Index>> sparse_near_;
};

/// Gives all samples joined to the start signs that agree with its own, by Prim's algorithm; returns these samples.
std::vector<Index> spread_sign(PointCloud& cloud, const SignLinks& links, Index start, std::vector<char>& reached) {
  using Edge = std::tuple<double, Index, Index>;  // doubt, from, to
  std::priority_queue<Edge, std::vector<Edge>, std::greater<>> edges;
  std::vector<Index> part;
  const auto reach = [&](Index i) {
    reached[i] = 1;
    part.push_back(i);
    links.for_each(i, [&](Index j) {
      const Vector3d step_m = cloud.points_m.col(j) - cloud.points_m.col(i);
      if (reached[j] != 0 || !(step_m.squaredNorm() > 0.0)) return;
      edges.emplace(1.0 - std::abs(carried(cloud.normals.col(i), step_m).dot(cloud.normals.col(j))), i, j);
    });
  };
  reach(start);
  while (!edges.empty()) {
    const auto [doubt, from, to] = edges.top();
    edges.pop();
    if (reached[to] != 0) continue;
    const Vector3d step_m = cloud.points_m.col(to) - cloud.points_m.col(from);
    if (carried(cloud.normals.col(from), step_m).dot(cloud.normals.col(to)) < 0.0) cloud.normals.col(to) *= -1.0;
    reach(to);
  }
  return part;
}

/// Returns three times the volume enclosed by the samples, in units of the area of one sample: negative if they point
/// inward.
double volume(const PointCloud& cloud, const std::vector<Index>& part) {
  double sum = 0.0;
  for (const Index i : part) sum += cloud.normals.col(i).dot(cloud.points_m.col(i) - cloud.points_m.col(part.front()));
  return sum;
}

double spacing_of(const PointCloud& cloud) {
  const double spacing_m = sample_spacing_m(cloud);
  if (spacing_m > 0.0) return spacing_m;
  throw std::invalid_argument("its points lie in a few places, many in each: leave out the copies");
}

}  // namespace

double share_off_planes(const PointCloud& cloud) {
  const LocalSamples samples(cloud, spacing_of(cloud));
  const Index step = std::max<Index>(1, cloud.points_m.cols() / 1000);
  Index off = 0, seen = 0;
  for (Index i = 0; i < cloud.points_m.cols(); i += step) {
    ++seen;
    const LocalPlane plane = plane_near(cloud, samples, i);
    if (plane.is_one && std::abs(plane.normal.dot(cloud.normals.col(i))) < std::sqrt(0.5)) ++off;
  }
  return static_cast<double>(off) / static_cast<double>(seen);
}

void estimate_normals(PointCloud& cloud) {
  const Index count = cloud.points_m.cols();
  const LocalSamples samples(cloud, spacing_of(cloud));
  cloud.normals.resize(3, count);
  for (Index i = 0; i < count; ++i) cloud.normals.col(i) = plane_near(cloud, samples, i).normal;
  const SignLinks links(samples, count);
  std::vector<char> reached(count, 0);
  for (Index i = 0; i < count; ++i) {
    if (reached[i] != 0) continue;
    const std::vector<Index> part = spread_sign(cloud, links, i, reached);
    if (volume(cloud, part) >= 0.0) continue;
    for (const Index k : part) cloud.normals.col(k) *= -1.0;
  }
}

}  // namespace thenar
