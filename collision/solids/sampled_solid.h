// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "collision/implicit_surface.h"

namespace thenar {

/// A sample of a surface with the curvature around it. The height over the plane across n is
///     w(u) = -(k_1 u_1^2 + k_2 u_2^2) / 2,   u along t_1 and t_2 = n x t_1.
struct BentSample {
  Eigen::Vector3d p_m, n, t1;
  double k1_per_m = 0.0, k2_per_m = 0.0;  ///< Principal curvatures, the larger first; > 0: convex.

  [[nodiscard]] Eigen::Vector3d t2() const { return n.cross(t1); }
};

/// A point where faces of a solid meet: a corner, or a point on an edge.
struct SharpPoint {
  Eigen::Vector3d p_m;
  Eigen::Vector3d along = Eigen::Vector3d::Zero();  ///< The edge's direction; zero for a corner.
  bool is_straight = false;  ///< True between two others on a straight edge: planes meet these first.
};

/// Points grouped in bounding balls of sixteen each, for searches by distance.
class PointBalls {
 public:
  /// Requires an order in which neighbours are consecutive.
  explicit PointBalls(const std::vector<Eigen::Vector3d>& points_m);

  /// Calls visit(i) for every point i whose balls all satisfy near(middle, radius).
  template <typename Near, typename Visit>
  void for_each(const Near& near, const Visit& visit) const {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (!near(groups_[g].middle_m, groups_[g].radius_m)) continue;
      for (std::size_t b = kBall * g; b < std::min(balls_.size(), kBall * (g + 1)); ++b) {
        if (!near(balls_[b].middle_m, balls_[b].radius_m)) continue;
        for (std::size_t i = kBall * b; i < std::min(points_, kBall * (b + 1)); ++i) visit(i);
      }
    }
  }

 private:
  static constexpr std::size_t kBall = 16;
  struct Ball {
    Eigen::Vector3d middle_m;
    double radius_m;
  };

  std::vector<Ball> balls_, groups_;  // A group has sixteen balls.
  std::size_t points_ = 0;
};

/// A solid whose surface is given by samples, prepared for contacts with exact ones. Curvatures come from neighbouring
/// samples; edges and corners, which have no samples, are where samples' planes meet.
class SampledSolid {
 public:
  /// Requires samples that make a surface (ImplicitSurface), with normals.
  explicit SampledSolid(const PointCloud& cloud);

  [[nodiscard]] const std::vector<BentSample>& bent() const { return bent_; }  ///< The samples that are not flat.
  [[nodiscard]] const std::vector<BentSample>& flat() const { return flat_; }  ///< The others.
  [[nodiscard]] const std::vector<SharpPoint>& sharp() const {
    return sharp_;
  }  ///< Points on straight edges last; each far from those before it.
  [[nodiscard]] const PointBalls& bent_balls() const { return bent_balls_; }
  [[nodiscard]] const PointBalls& flat_balls() const { return flat_balls_; }
  [[nodiscard]] const ImplicitSurface& surface() const { return surface_; }
  [[nodiscard]] double spacing_m() const { return spacing_m_; }
  [[nodiscard]] double reach_m() const { return reach_m_; }  ///< Radius of the least ball about the origin around it.
  /// Returns the curvature below which the whole solid deviates from a plane by less than 10 nm.
  [[nodiscard]] double flat_per_m() const { return flat_per_m_; }
  [[nodiscard]] double most_bent_per_m() const { return most_bent_per_m_; }  ///< The largest curvature, not below 0.
  /// Return the surface's possible error at contacts of curved places, estimated from neighbouring samples, and of
  /// curved edges, which are polygons here.
  [[nodiscard]] double round_error_m() const { return round_error_m_; }
  [[nodiscard]] double edge_error_m() const { return edge_error_m_; }

 private:
  ImplicitSurface surface_;
  double spacing_m_, reach_m_, flat_per_m_;
  double most_bent_per_m_ = 0.0, round_error_m_ = 0.0, edge_error_m_ = 0.0;
  std::vector<BentSample> bent_, flat_;
  std::vector<SharpPoint> sharp_;
  PointBalls bent_balls_, flat_balls_;
};

}  // namespace thenar
