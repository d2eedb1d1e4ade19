#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <concepts>
#include <optional>
#include <span>
#include <vector>

#include "collision/point_cloud.h"
#include "collision/sample_blocks.h"

namespace thenar {

/// Where a point stands to a surface.
struct SurfaceDistance {
  double distance_m;        ///< Signed, > 0 outside.
  Eigen::Vector3d point_m;  ///< The point's projection on the surface.
  Eigen::Vector3d normal;   ///< Outward unit normal there.
};

/// The surface that a point cloud stands for [Adamson & Alexa 2003; Keiser et al. 2004]:
///     a(x) = sum th_i p_i / sum th_i,   n(x) = normalised sum th_i n_i,   f(x) = n.(x - a).
/// Weights fall with distance and with the angle between n_i and n, up to 60 degrees, so that n and a belong to one
/// face:
///     th_i = max(0, 1 - d_i^2/h^2)^4 max(0, 2 n_i.n - 1)^4.
/// Where faces meet (the sides of an edge or a corner, the two sides of a plate) the solid is the intersection of their
/// half-spaces if they meet convexly, else the union: f is the largest or the smallest of theirs.
///
/// It trusts the samples: see repair() in cloud_repair.h.
class ImplicitSurface {
 public:
  /// Support h = 2.2 sample spacings, the spacing measured on the cloud.
  /// Throws std::invalid_argument if there are no samples, or if they have no spacing (a single place).
  explicit ImplicitSurface(const PointCloud& cloud);

  /// Throws std::invalid_argument if there are no samples, or if the support is not finite and greater than zero.
  ImplicitSurface(const PointCloud& cloud, double support_m);
  ImplicitSurface(const PointCloud& cloud, std::integral auto) = delete;  // no number of samples is a support

  /// Signed distance of x: on each face near the nearest sample x is projected twice.
  /// Nothing if no sample lies within `reach_m` of x. Outside a convex edge or
  /// corner f is a lower bound: the largest distance to one of the planes. Requires x finite. Never NaN. Does
  /// not allocate or throw.
  [[nodiscard]] std::optional<SurfaceDistance> distance(const Eigen::Vector3d& x_m, double reach_m) const noexcept;

  /// The sample nearest to x, where its projections start: distance(x, reach) is distance_from(x, nearest(x,
  /// reach).sample) if there is one. See SampleBlocks::nearest().
  [[nodiscard]] SampleBlocks::Nearest nearest(const Eigen::Vector3d& x_m, double reach_m, double beyond_m = 0.0,
                                              Eigen::Index hint = -1) const noexcept {
    return blocks_.nearest(x_m, reach_m, beyond_m, hint);
  }
  [[nodiscard]] SurfaceDistance distance_from(const Eigen::Vector3d& x_m, Eigen::Index sample) const noexcept;

  /// How x stands to the plane of the samples around one: the first projection of distance_from(). point_m is the
  /// middle of those samples.
  [[nodiscard]] SurfaceDistance plane_distance(const Eigen::Vector3d& x_m, Eigen::Index sample) const noexcept;

  /// How x stands to the face that a sample belongs to, whatever other faces are nearer: to the near side of a wall
  /// from beyond its middle, say.
  [[nodiscard]] SurfaceDistance face_distance(const Eigen::Vector3d& x_m, Eigen::Index sample) const noexcept;

  /// What distance_from(x, sample) is about, without the second projection.
  struct Estimate {
    double distance_m;  ///< After the first projection.
    double least_m;     ///< The distance is this or more; -inf near edges, where several faces compete.
    double firm_m;  ///< While x moves no farther and starts from this sample, least_m falls no faster than it moves.
  };
  [[nodiscard]] Estimate estimate(const Eigen::Vector3d& x_m, Eigen::Index sample) const noexcept;

  [[nodiscard]] const PointCloud& cloud() const { return cloud_; }  ///< In the order of the blocks.
  [[nodiscard]] const Eigen::AlignedBox3d& bounds() const { return bounds_; }
  [[nodiscard]] double support_m() const { return support_m_; }

 private:
  using Block = SampleBlocks::Block;
  using Lanes = SampleBlocks::Lanes;

  /// The plane a, n that the samples around a point make.
  struct Plane {
    Eigen::Vector3d a_m, n;
    double least_cosine;  ///< Between the reference normal and those of the samples in the support.
  };

  /// The first projection of every x that is nearest to a sample: its plane depends on the sample alone. Of the samples
  /// that the second one may use if it stays near, it says how high they rise above this plane and how far their
  /// normals lean from its.
  struct Start {
    Plane plane;
    double rise_m, cosine, lean_m;
    double clear_m;  ///< Within this of the sample no normal is unlike a second projection's that stays near.
  };

  /// A face as x sees it: the plane near x's projection.
  struct Face {
    Eigen::Vector3d a_m, n;
    double f_m;           ///< n.(x - a)
    double least_cosine;  ///< Of the start's plane.
  };

  /// How far from the first sample of a block all normals are within 45 degrees of the mean of the block's.
  struct BlockClearance {
    Eigen::Vector3d centre_m, axis;
    double clear_m;
  };

  void fill_clearances();
  void fill_starts();
  [[nodiscard]] Eigen::Vector3d point_m(Eigen::Index sample) const { return cloud_.points_m.col(sample); }
  [[nodiscard]] double clear_m(Eigen::Index sample, const Plane& plane, double least_cosine) const;
  [[nodiscard]] Eigen::Index nearest_unlike(const Eigen::Vector3d& x_m, const Eigen::Vector3d& c_m, double radius_m,
                                            std::span<const Eigen::Vector3d> seen) const noexcept;
  [[nodiscard]] std::optional<Plane> fit(const Eigen::Vector3d& c_m, const Eigen::Vector3d& n_reference) const noexcept;
  /// Whether no sample within the radius of the start has a normal unlike n, a second projection's.
  [[nodiscard]] bool is_clear(Eigen::Index start, const Eigen::Vector3d& n, double radius_m) const noexcept {
    return radius_m <= starts_[start].clear_m && n.dot(starts_[start].plane.n) >= starts_[start].cosine;
  }
  /// How far around a point inside other faces are looked for, which is at this distance from the nearest sample.
  [[nodiscard]] double widest_m(double way_m) const { return std::max(support_m_, 2.0 * way_m + 0.25 * support_m_); }
  [[nodiscard]] static Eigen::Vector3d mean_normal(const Face& face, std::span<const Face> convex) noexcept;
  [[nodiscard]] Face project(const Eigen::Vector3d& x_m, Eigen::Index start) const noexcept;

  PointCloud cloud_;
  SampleBlocks blocks_;
  Eigen::AlignedBox3d bounds_;
  double support_m_;
  std::vector<BlockClearance> clearances_;  // of each block
  std::vector<Start> starts_;               // of each sample
};

}  // namespace thenar
