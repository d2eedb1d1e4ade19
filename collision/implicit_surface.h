#pragma once

#include <Eigen/Core>
#include <optional>

#include "collision/point_cloud.h"
#include "collision/sphere_tree.h"

namespace thenar {

/// Where a point stands to a surface.
struct SurfaceDistance {
  double distance_m;        ///< Signed, > 0 outside.
  Eigen::Vector3d point_m;  ///< The point's projection on the surface.
  Eigen::Vector3d normal;   ///< Outward unit normal there.
};

/// The surface that a point cloud stands for [Adamson & Alexa 2003; Keiser et al. 2004]:
///     a(x) = sum th_i p_i / sum th_i,   n(x) = normalised sum th_i n_i,   f(x) = n.(x - a).
/// Weights fall with distance, th = (1 - d^2/h^2)^4, and with the angle between n_i and n, so that edges stay sharp and
/// the two sides of a plate do not mix.
class ImplicitSurface {
 public:
  /// Support h = 2.2 sample spacings, the spacing measured on the cloud.
  ImplicitSurface(PointCloud cloud, Eigen::Index leaves);
  ImplicitSurface(PointCloud cloud, Eigen::Index leaves, double support_m);

  /// Signed distance of x: projects twice, from the nearest sample on.
  /// Nothing if no sample lies within `reach_m` of x, or if the normals around the projection cancel.
  /// Does not allocate or throw.
  [[nodiscard]] std::optional<SurfaceDistance> distance(const Eigen::Vector3d& x_m, double reach_m) const noexcept;

  [[nodiscard]] const PointCloud& cloud() const { return cloud_; }
  [[nodiscard]] const SphereTree& tree() const { return tree_; }
  [[nodiscard]] const Eigen::AlignedBox3d& bounds() const { return bounds_; }
  [[nodiscard]] double support_m() const { return support_m_; }

 private:
  PointCloud cloud_;  // in the tree's order, so that a leaf's samples are neighbours in memory
  SphereTree tree_;
  Eigen::AlignedBox3d bounds_;
  double support_m_;
};

}  // namespace thenar
