#include "collision/implicit_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// Normals more than 60 degrees apart belong to two faces; less is curvature, or noise. 60 degrees is where a sample's
// weight ends: max(0, 2 cos - 1).
constexpr double kUnlike = 0.5;

// A lone sample is no face of its own: some neighbour must add to its weight of 1. Keeps single bad normals out.
constexpr double kLeastWeight = 1.0001;

// How far a first projection may lie from the middle of its plane, in supports, for the bounds on the second to hold.
// About a spacing: nearly all do.
constexpr double kStray = 0.5;

// More than rounding does to a length [m] below a metre or to a cosine.
constexpr double kRounding = 1e-12;

PointCloud in_block_order(const PointCloud& cloud, Index leaves) {
  if (leaves < 1 || leaves > cloud.points_m.cols()) {
    throw std::invalid_argument("ImplicitSurface: leaves must be between 1 and the number of points");
  }
  const std::vector<Index> order = SampleBlocks::order(cloud.points_m);
  return {cloud.points_m(Eigen::all, order), cloud.normals(Eigen::all, order)};
}

double default_support_m(const PointCloud& cloud) {
  // 2.2 spacings reach about 15 samples: enough to average, few enough to stay local.
  return 2.2 * sample_spacing_m(cloud);
}

}  // namespace

ImplicitSurface::ImplicitSurface(const PointCloud& cloud, Index leaves)
    : ImplicitSurface(cloud, leaves, default_support_m(cloud)) {}

ImplicitSurface::ImplicitSurface(const PointCloud& cloud, Index leaves, double support_m)
    : cloud_(in_block_order(cloud, leaves)), blocks_(cloud_), support_m_(support_m) {
  if (!(support_m > 0.0) || !std::isfinite(support_m)) {
    throw std::invalid_argument("ImplicitSurface: the support must be finite and greater than zero");
  }
  bounds_ = {Vector3d(cloud_.points_m.rowwise().minCoeff()), Vector3d(cloud_.points_m.rowwise().maxCoeff())};
  fill_starts();
}

void ImplicitSurface::fill_starts() {
  starts_.reserve(cloud_.points_m.cols());
  for (Index i = 0; i < cloud_.points_m.cols(); ++i) {
    // A sample weighs 1 in its own plane: there is one, unless its normal is none.
    const std::optional<Plane> plane = fit(point_m(i), cloud_.normals.col(i));
    if (!plane) throw std::invalid_argument("ImplicitSurface: normals must be of length one");
    const Vector3d n = plane->n;
    Lanes rise_m = Lanes::Zero(), cosine = Lanes::Ones();
    const double radius_m = (1.0 + kStray) * support_m_;
    blocks_.for_each_near(plane->a_m, radius_m, [&](const Block& block, Index) {
      const Lanes from_n = block.cosines(n);
      const auto counts = from_n > kUnlike - kRounding && block.squared_distances(plane->a_m) < radius_m * radius_m;
      rise_m = rise_m.max(counts.select(block.heights(plane->a_m, n), 0.0));
      cosine = cosine.min(counts.select(from_n, 1.0));
    });
    const double least = std::clamp(cosine.minCoeff() - kRounding, 0.0, 1.0);
    starts_.push_back({*plane, rise_m.maxCoeff() + kRounding, least, std::sqrt(1.0 - least * least) * support_m_});
  }
}

/// The sample nearest to x among those in the support about c whose normals are unlike both n_1 and n_2, or -1.
Index ImplicitSurface::nearest_unlike(const Vector3d& x_m, const Vector3d& c_m, const Vector3d& n_1,
                                      const Vector3d& n_2) const noexcept {
  Index found = -1;
  double best_squared = std::numeric_limits<double>::infinity();
  blocks_.for_each_near(c_m, support_m_, [&](const Block& block, Index number) {
    const Lanes squared = block.squared_distances(x_m), from_c = block.squared_distances(c_m);
    const Lanes cosine = block.cosines(n_1).max(block.cosines(n_2));
    for (int k = 0; k < SampleBlocks::kLanes; ++k) {
      if (cosine[k] >= kUnlike || from_c[k] >= support_m_ * support_m_ || squared[k] >= best_squared) continue;
      best_squared = squared[k];
      found = SampleBlocks::kLanes * number + k;
    }
  });
  return found;
}

/// The plane a(c), n(c). Nothing if no sample near c has a normal like the reference.
std::optional<ImplicitSurface::Plane> ImplicitSurface::fit(const Vector3d& c_m,
                                                           const Vector3d& n_reference) const noexcept {
  const double inv_h2 = 1.0 / (support_m_ * support_m_);
  Lanes sum = Lanes::Zero(), a_x = sum, a_y = sum, a_z = sum, n_x = sum, n_y = sum, n_z = sum;
  Lanes least_cosine = Lanes::Ones();
  blocks_.for_each_near(c_m, support_m_, [&](const Block& block, Index) {
    const Lanes near = (1.0 - block.squared_distances(c_m) * inv_h2).max(0.0);
    const Lanes cosine = block.cosines(n_reference);
    const Lanes th = (near * (2.0 * cosine - 1.0).max(0.0)).square().square();
    sum += th;
    a_x += th * (block.x - c_m.x());
    a_y += th * (block.y - c_m.y());
    a_z += th * (block.z - c_m.z());
    n_x += th * block.n_x;
    n_y += th * block.n_y;
    n_z += th * block.n_z;
    least_cosine = least_cosine.min((near > 0.0).select(cosine, 1.0));
  });
  const double weight = sum.sum();
  // At the rim of the support 1 - d^2/h^2 is rounding below 1e-3, to the fourth power 1e-12.
  if (!(weight > 1e-12)) return std::nullopt;
  const Vector3d a_m = c_m + Vector3d(a_x.sum(), a_y.sum(), a_z.sum()) / weight;
  return Plane{a_m, Vector3d(n_x.sum(), n_y.sum(), n_z.sum()).normalized(), weight, least_cosine.minCoeff()};
}

/// Projects x twice, from a sample on.
ImplicitSurface::Face ImplicitSurface::project(const Vector3d& x_m, Index start) const noexcept {
  const Plane& first = starts_[start].plane;
  const double f_m = first.n.dot(x_m - first.a_m);
  const std::optional<Plane> second = fit(x_m - f_m * first.n, first.n);
  // Past an edge or over a hole the projection leaves the samples: the first plane, extended, is the face.
  if (!second) return {first.a_m, first.n, f_m, first.weight, first.least_cosine};
  return {second->a_m, second->n, second->n.dot(x_m - second->a_m), first.weight, first.least_cosine};
}

std::optional<SurfaceDistance> ImplicitSurface::distance(const Vector3d& x_m, double reach_m) const noexcept {
  const Index start = nearest(x_m, reach_m).sample;
  if (start < 0) return std::nullopt;
  return distance_from(x_m, start);
}

std::optional<SurfaceDistance> ImplicitSurface::distance_from(const Vector3d& x_m, Index start) const noexcept {
  Face face = project(x_m, start);
  if (face.least_cosine < kUnlike) {
    // Near an edge the nearest sample may lie on either side; near a corner three faces meet.
    const Vector3d n_1 = face.n;
    Vector3d n_2 = n_1;
    for (int other = 0; other < 2; ++other) {
      const Index beyond = nearest_unlike(x_m, point_m(start), n_1, n_2);
      if (beyond < 0) break;
      const Face next = project(x_m, beyond);
      n_2 = next.n;
      if (next.weight < kLeastWeight) continue;
      // Convex: each face lies behind the other's plane.
      const bool convex = (face.n - next.n).dot(next.a_m - face.a_m) < 0.0;
      if (convex ? next.f_m > face.f_m : next.f_m < face.f_m) face = next;
    }
  }
  return SurfaceDistance{face.f_m, x_m - face.f_m * face.n, face.n};
}

/// With x - a = f_1 n_1 + (c - a), c the first projection, and n_2 at an angle phi from n_1, the second projection gives
///     f_2 = n_2.(x - a_2) >= cos(phi) (f_1 - rise) - sin(phi) |c - a_2|,
/// for a_2 is a mean of samples that rise above the first plane no higher than `rise`. They lie within h of c, and phi is
/// no more than the largest angle of theirs.
ImplicitSurface::Estimate ImplicitSurface::estimate(const Vector3d& x_m, Index sample) const noexcept {
  const Start& start = starts_[sample];
  const Vector3d from_a = x_m - start.plane.a_m;
  const double f_m = start.plane.n.dot(from_a);
  const double stray_m = std::sqrt(std::max(0.0, from_a.squaredNorm() - f_m * f_m));
  const double firm_m = kStray * support_m_ - stray_m;
  if (start.plane.least_cosine < kUnlike || firm_m < kRounding) {
    return {f_m, -std::numeric_limits<double>::infinity(), 0.0};
  }
  const double height_m = f_m - start.rise_m;
  return {f_m, height_m * (height_m > 0.0 ? start.cosine : 1.0) - start.lean_m, firm_m};
}

}  // namespace thenar
