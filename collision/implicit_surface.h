#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

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
  /// Throws std::invalid_argument if leaves < 1 or > points, or if the samples have no spacing (a single place).
  ImplicitSurface(const PointCloud& cloud, Eigen::Index leaves);

  /// Throws std::invalid_argument if leaves < 1 or > points, or if the support is not finite and greater than zero.
  ImplicitSurface(const PointCloud& cloud, Eigen::Index leaves, double support_m);

  /// Signed distance of x: on each face near the nearest sample x is projected twice.
  /// Nothing if no sample lies within `reach_m` of x, or if the normals around x cancel. Outside a convex edge or
  /// corner f is a lower bound: the largest distance to one of the planes. Requires x finite. Never NaN. Does
  /// not allocate or throw.
  [[nodiscard]] std::optional<SurfaceDistance> distance(const Eigen::Vector3d& x_m, double reach_m) const noexcept;

  [[nodiscard]] const PointCloud& cloud() const { return cloud_; }
  [[nodiscard]] const SphereTree& tree() const { return tree_; }
  [[nodiscard]] const Eigen::AlignedBox3d& bounds() const { return bounds_; }
  [[nodiscard]] double support_m() const { return support_m_; }

 private:
  static constexpr int kLanes = 8;
  using Lanes = Eigen::Array<double, kLanes, 1>;

  struct Sample {
    Eigen::Vector3d point_m, normal;
  };

  /// Up to eight samples of a leaf, each coordinate contiguous. Unused lanes have no normal and lie too
  /// far away to weigh anything.
  struct Block {
    Lanes x, y, z;
    Lanes n_x, n_y, n_z;

    [[nodiscard]] Sample sample(int lane) const {
      return {{x[lane], y[lane], z[lane]}, {n_x[lane], n_y[lane], n_z[lane]}};
    }
    [[nodiscard]] Lanes squared_distances(const Eigen::Vector3d& p) const {
      return (x - p.x()).square() + (y - p.y()).square() + (z - p.z()).square();
    }
    [[nodiscard]] Lanes cosines(const Eigen::Vector3d& n) const { return n_x * n.x() + n_y * n.y() + n_z * n.z(); }
    /// Heights of the samples over the plane through p with normal n.
    [[nodiscard]] Lanes heights(const Eigen::Vector3d& p, const Eigen::Vector3d& n) const {
      return (x - p.x()) * n.x() + (y - p.y()) * n.y() + (z - p.z()) * n.z();
    }
  };

  /// A face as x sees it: the plane near x's projection.
  struct Face {
    Eigen::Vector3d a_m, n;
    double f_m;           ///< n.(x - a)
    double weight;        ///< sum th_i; a sample at the centre of the support counts 1.
    double least_cosine;  ///< Between the reference normal and those of the samples in the support.
  };

  void fill_blocks();
  template <typename Visit>
  void for_each_block(const Eigen::Vector3d& c_m, double radius_m, Visit visit) const;
  [[nodiscard]] std::optional<Sample> nearest(const Eigen::Vector3d& x_m, double reach_m) const noexcept;
  [[nodiscard]] std::optional<Sample> nearest_unlike(const Eigen::Vector3d& x_m, const Eigen::Vector3d& c_m,
                                                     double radius_m,
                                                     std::span<const Eigen::Vector3d> seen) const noexcept;
  [[nodiscard]] std::optional<Face> fit(const Eigen::Vector3d& x_m, const Eigen::Vector3d& c_m,
                                        const Eigen::Vector3d& n_reference) const noexcept;
  [[nodiscard]] std::optional<Face> project(const Eigen::Vector3d& x_m, const Sample& start) const noexcept;

  PointCloud cloud_;  // in the tree's order, so that a leaf's samples are neighbours in memory
  SphereTree tree_;
  Eigen::AlignedBox3d bounds_;
  double support_m_;
  std::vector<Block> blocks_;
  std::vector<Eigen::Index> first_block_;  // of each leaf, and one past the last
};

}  // namespace thenar
