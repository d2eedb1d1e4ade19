// SPDX-License-Identifier: Apache-2.0
#include "collision/cloud_holes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "collision/point_grid.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

// The rim of a hole as wide as the support is 14 spacings long. Holes seen by fewer samples are the air around one that
// is off the surface.
constexpr int kFewestAtARim = 3;

/// Returns the step from sample i to sample j along the surface, as a vector in the tangent plane of i: a drop beyond
/// an edge is added to its outward part. Zero for the other side of a plate, which is no neighbour.
Vector3d unfolded_step_m(const PointCloud& cloud, Index i, Index j) {
  const Vector3d n = cloud.normals.col(i), step_m = cloud.points_m.col(j) - cloud.points_m.col(i);
  const double drop_m = -step_m.dot(n), cosine = cloud.normals.col(j).dot(n);
  const Vector3d along_m = step_m + drop_m * n, outward = cloud.normals.col(j) - cosine * n;
  const double turn = outward.norm();
  // Where the surface hardly turns there is no direction to unfold to, and nothing to unfold.
  if (turn < 0.1) return cosine > 0.0 ? along_m : Vector3d::Zero();
  return along_m + drop_m / turn * outward;
}

/// Finds the largest empty ball that touches sample i beside its neighbours; nothing if not larger than the support.
std::optional<CloudHole> empty_ball(const PointCloud& cloud, const PointGrid& grid, double sight_m, Index i,
                                    double support_m) {
  Vector3d sum_m = Vector3d::Zero();
  double weight = 0.0;
  grid.for_each_neighbour(i, [&](Index j, double distance_m) {
    if (distance_m >= 1.5 * support_m) return;
    const double near = 1.0 - distance_m * distance_m / (2.25 * support_m * support_m);
    weight += near;
    sum_m += near * unfolded_step_m(cloud, i, j);
  });
  // In the midst of its neighbours; beside a hole as large as the support their mean lies 0.3 h off.
  if (!(sum_m.norm() > 0.15 * support_m * weight)) return std::nullopt;
  const Vector3d away = -sum_m.normalized();
  double radius_m = sight_m;
  bool thin = false, goes_on = false;
  grid.for_each_neighbour(i, [&](Index j, double distance_m) {
    // The other side of a plate thinner than the support, and whether it goes on below the ball.
    const Vector3d below_m = cloud.points_m.col(j) - cloud.points_m.col(i);
    if (cloud.normals.col(j).dot(cloud.normals.col(i)) < -0.5 && below_m.dot(cloud.normals.col(i)) < 0.0) {
      thin = thin || distance_m < support_m;
      goes_on = goes_on || below_m.dot(away) > 0.5 * support_m;
    }
    const Vector3d step_m = unfolded_step_m(cloud, i, j);
    // The ball through both samples: |step|^2 = 2 r away.step.
    const double ahead_m = step_m.dot(away);
    if (ahead_m > 0.0) radius_m = std::min(radius_m, step_m.squaredNorm() / (2.0 * ahead_m));
  });
  // The rim of a plate thinner than a spacing may have no sample: both sides end there.
  if (!(radius_m > support_m) || (thin && !goes_on)) return std::nullopt;
  return CloudHole{cloud.points_m.col(i) + radius_m * away, radius_m};
}

}  // namespace

std::vector<CloudHole> find_holes(const PointCloud& cloud, double support_m, double largest_m) {
  if (cloud.points_m.cols() == 0) return {};
  // First the gaps of neighbours within the support, then, for these few, their extent.
  std::vector<Index> beside;
  {
    const double sight_m = 2.0 * support_m;
    const PointGrid grid(cloud.points_m, sight_m);
    for (Index i = 0; i < cloud.points_m.cols(); ++i) {
      if (empty_ball(cloud, grid, sight_m, i, support_m)) beside.push_back(i);
    }
  }
  std::vector<CloudHole> balls;
  if (!beside.empty()) {
    const double sight_m = 2.0 * largest_m;
    const PointGrid grid(cloud.points_m, sight_m);
    for (const Index i : beside) {
      if (auto ball = empty_ball(cloud, grid, sight_m, i, support_m)) {
        ball->radius_m = std::min(ball->radius_m, largest_m);
        balls.push_back(*ball);
      }
    }
  }

  // Balls that overlap lie in one hole: the largest stands for it.
  std::ranges::stable_sort(balls, [](const CloudHole& a, const CloudHole& b) { return a.radius_m > b.radius_m; });
  std::vector<CloudHole> holes;
  std::vector<int> rim;  // Samples at each hole.
  for (const CloudHole& ball : balls) {
    const auto known = std::ranges::find_if(holes, [&](const CloudHole& hole) {
      return (hole.centre_m - ball.centre_m).norm() < hole.radius_m + ball.radius_m;
    });
    if (known != holes.end()) {
      ++rim[known - holes.begin()];
    } else {
      holes.push_back(ball);
      rim.push_back(1);
    }
  }
  std::vector<CloudHole> real;
  for (std::size_t i = 0; i < holes.size(); ++i) {
    if (rim[i] >= kFewestAtARim) real.push_back(holes[i]);
  }
  return real;
}

}  // namespace thenar
