// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <concepts>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "collision/point_cloud.h"
#include "collision/sample_blocks.h"
#include "collision/surface_bend.h"
#include "collision/surface_patches.h"

namespace thenar {

/// The signed distance and foot of a point on a surface.
struct SurfaceDistance {
  double distance_m;        ///< Signed, > 0 outside.
  Eigen::Vector3d point_m;  ///< The point's projection on the surface.
  Eigen::Vector3d normal;   ///< Outward unit normal there.
  bool is_smooth = true;    ///< True if only the projection's face contributes.
};

/// The surface of a point cloud [Adamson & Alexa 2003; Keiser et al. 2004; Guennebaud & Gross 2007]. It is the plane
/// through
///     a(x) = sum th_i p_i / sum th_i   with the normal   n(x) = normalised sum th_i n_i,   f(x) = n.(x - a),
/// shifted and tilted to touch, over x, the sphere through these samples (sphere_fit.h): their mean lies below a curved
/// surface. Weights decrease with distance and with the angle between n_i and n, up to 60 degrees, so that n and a
/// belong to one face:
///     th_i = max(0, 1 - d_i^2/h^2)^4 max(0, 2 n_i.n - 1)^4.
/// Where faces meet (the sides of an edge or a corner, the two sides of a plate) the solid is the intersection of their
/// half-spaces if they meet convexly, else the union: f is the largest or the smallest of theirs.
///
/// The samples must be consistent: see repair() in cloud_repair.h.
class ImplicitSurface {
 public:
  /// Makes the surface with the support h = 2.2 sample spacings, measured on the cloud.
  /// Throws std::invalid_argument if there are no samples, or if they have no spacing (a single place).
  explicit ImplicitSurface(const PointCloud& cloud);

  /// Throws std::invalid_argument if there are no samples, or if the support is not finite and positive.
  ImplicitSurface(const PointCloud& cloud, double support_m);
  ImplicitSurface(const PointCloud& cloud, std::integral auto) = delete;  // no number of samples is a support

  /// Allows distances up to `depth_m` from the surface to differ from the exact ones by `error_m`, for speed: where a
  /// sample's patch has that accuracy it is used (SurfacePatches). Takes about 3 us and 224 bytes a sample. Without it,
  /// or with an error of 0, all are exact.
  void allow_error(double error_m, double depth_m);

  /// Computes the signed distance of x: on each face near the nearest sample x is projected twice. Nothing if no sample
  /// lies within `reach_m` of x. Outside a convex edge or corner f is a lower bound: the largest distance to one of the
  /// planes. Requires x finite. Never NaN. Does not allocate or throw.
  [[nodiscard]] std::optional<SurfaceDistance> distance(const Eigen::Vector3d& x_m, double reach_m) const noexcept;

  /// Finds the sample nearest to x, where its projections start: distance(x, reach) is distance_from(x, nearest(x,
  /// reach).sample) if there is one. See SampleBlocks::nearest().
  [[nodiscard]] SampleBlocks::Nearest nearest(const Eigen::Vector3d& x_m, double reach_m, double beyond_m = 0.0,
                                              Eigen::Index hint = -1) const noexcept {
    return blocks_.nearest(x_m, reach_m, beyond_m, hint);
  }
  [[nodiscard]] SurfaceDistance distance_from(const Eigen::Vector3d& x_m, Eigen::Index sample) const noexcept;

  /// Computes the distance of x from a sample's face even if other faces are nearer: from the near side of a wall for x
  /// beyond its middle, say.
  [[nodiscard]] SurfaceDistance face_distance(const Eigen::Vector3d& x_m, Eigen::Index sample) const noexcept;

  /// Finds for each sample the other faces within `reach_m` of it across convex edges: the nearest sample of each, of
  /// kMostBeside at most. `are_one(i, j)` tells that two samples share a face. Without it, a surface that turns by more
  /// than 45 degrees over that distance has no edge there, and blunt edges, over which normals turn by 20 to 60
  /// degrees, are found, too: around these, distances and curvatures are those of a face's own samples from then on.
  /// Some us a sample. Calls forget_edges() first.
  void find_edges(double reach_m, const std::function<bool(Eigen::Index, Eigen::Index)>& are_one = {});
  /// Restores the surface as before find_edges().
  void forget_edges();
  static constexpr std::size_t kMostBeside = 5;
  /// Returns the samples of the other faces beside a sample; none before find_edges().
  [[nodiscard]] std::span<const Eigen::Index> beside(Eigen::Index sample) const {
    if (beside_.empty()) return {};
    const Beside& found = beside_[sample];
    return {found.samples.data(), found.count};
  }

  /// Bounds of distance_from(x, sample) without computing it; none near edges, where several faces compete, nor where
  /// all is exact.
  using Estimate = SurfacePatches::Estimate;
  [[nodiscard]] Estimate estimate(const Eigen::Vector3d& x_m, Eigen::Index sample) const noexcept;

  /// Returns the curvature at a sample; at an edge, that of the sample's own face.
  [[nodiscard]] const SurfaceBend& bend(Eigen::Index sample) const { return bends_[sample]; }

  [[nodiscard]] const PointCloud& cloud() const { return cloud_; }  ///< In the order of the blocks.
  [[nodiscard]] const Eigen::AlignedBox3d& bounds() const { return bounds_; }
  [[nodiscard]] double support_m() const { return support_m_; }

 private:
  using Block = SampleBlocks::Block;
  using Lanes = SampleBlocks::Lanes;

  /// The plane a, n through the samples around a point.
  struct Plane {
    Eigen::Vector3d a_m, n;
    double least_cosine;  ///< Least cosine between the reference normal and those of the samples in the support.
  };

  /// The first projection of all x nearest to a sample: its plane depends on the sample alone. It bounds the angles
  /// from its normal to those of the samples that a second projection nearby may use.
  struct Start {
    Plane plane;
    double cosine;
    double clear_m;         ///< Radius in which no normal is unlike that of a second projection nearby.
    bool is_sharp = false;  ///< At a blunt edge: only samples with normals within 20 degrees make its planes.
  };

  /// Samples of other faces.
  struct Beside {
    std::array<Eigen::Index, kMostBeside> samples{};
    std::size_t count = 0;
  };

  /// Values of a sample at a blunt edge before edges were sought.
  struct Blunted {
    Eigen::Index sample;
    Start start;
    SurfaceBend bend;
  };

  /// A face near x: the plane near x's projection.
  struct Face {
    Eigen::Vector3d a_m;  ///< The middle of its samples: near x's projection, or near the start.
    Eigen::Vector3d n;
    double f_m;  ///< Height of x over the plane.
  };

  /// The distance from the first sample of a block within which all normals are within 45 degrees of the block's mean.
  struct BlockClearance {
    Eigen::Vector3d centre_m, axis;
    double clear_m;
  };

  void fill_clearances();
  void fill_starts();
  [[nodiscard]] SurfaceBend bend_at(Eigen::Index sample, double unlike) const;
  void find_blunt_edges(double reach_m);
  [[nodiscard]] bool is_blunt_end(Eigen::Index sample, Eigen::Index other, double reach_m) const;
  [[nodiscard]] bool is_at_edge(Eigen::Index sample) const;
  [[nodiscard]] bool ends_at(const Plane& other, double hollow_per_m, const Plane& face, const Eigen::Vector3d& p_m,
                             double reach_m) const;
  void drop_unmet(Eigen::Index i, double reach_m);
  [[nodiscard]] Eigen::Vector3d point_m(Eigen::Index sample) const { return cloud_.points_m.col(sample); }
  [[nodiscard]] double clear_m(Eigen::Index sample, const Plane& plane, double least_cosine) const;
  [[nodiscard]] Eigen::Index nearest_unlike(const Eigen::Vector3d& x_m, const Eigen::Vector3d& c_m, double radius_m,
                                            std::span<const Eigen::Vector3d> seen, double unlike,
                                            std::span<const char> of = {}) const noexcept;
  [[nodiscard]] std::optional<Plane> fit(const Eigen::Vector3d& c_m, const Eigen::Vector3d& n_reference,
                                         bool is_sharp = false) const noexcept;
  /// Tests that no sample within the radius of the start has a normal unlike n, a second projection's.
  [[nodiscard]] bool is_clear(Eigen::Index start, const Eigen::Vector3d& n, double radius_m) const noexcept {
    return radius_m <= starts_[start].clear_m && n.dot(starts_[start].plane.n) >= starts_[start].cosine;
  }
  /// Returns the search radius for other faces around an inner point at this distance from the nearest sample.
  [[nodiscard]] double widest_m(double way_m) const { return std::max(support_m_, 2.0 * way_m + 0.25 * support_m_); }
  [[nodiscard]] bool is_alone(const Eigen::Vector3d& x_m, Eigen::Index start, double f_m,
                              const Eigen::Vector3d& n) const noexcept;
  [[nodiscard]] SurfaceDistance of_several_faces(const Eigen::Vector3d& x_m, Eigen::Index start,
                                                 const Face& first) const noexcept;
  [[nodiscard]] static Eigen::Vector3d mean_normal(const Face& face, std::span<const Face> convex) noexcept;
  [[nodiscard]] Face project(const Eigen::Vector3d& x_m, Eigen::Index start) const noexcept;

  PointCloud cloud_;
  SampleBlocks blocks_;
  Eigen::AlignedBox3d bounds_;
  double support_m_;
  std::vector<BlockClearance> clearances_;  // of each block
  std::vector<Start> starts_;               // of each sample
  std::vector<SurfaceBend> bends_;          // of each sample
  std::vector<Blunted> blunted_;
  std::vector<Beside> beside_;             // of each sample, after find_edges()
  std::optional<SurfacePatches> patches_;  // of each sample, where an error is allowed
};

}  // namespace thenar
