// SPDX-License-Identifier: Apache-2.0
#include "collision/implicit_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>
#include <vector>

#include "collision/sphere_fit.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// Normals more than 60 degrees apart belong to two faces; less is curvature, or noise. 60 degrees is where a sample's
// weight ends: max(0, 2 cos - 1).
constexpr double kUnlike = 0.5;

// Normals more than 20 degrees apart also do if they are like others on both sides.
constexpr double kBlunt = 0.94;

// A surface that bends by more over that distance has no edge.
constexpr double kMostTurn_rad = 0.25 * std::numbers::pi;

// Deeper than this, in supports, another face may be as near as the first one found.
constexpr double kDeep = 0.4;

// At a corner three faces meet, at that of a plate four.
constexpr std::size_t kMostFaces = 4;

// Distance of a first projection from the middle of its plane, in supports, up to which the bounds on the second hold.
// About a spacing, which nearly all keep.
constexpr double kStray = 0.5;

// More than rounding does to a length [m] below a metre or to a cosine.
constexpr double kRounding = 1e-12;

PointCloud in_block_order(const PointCloud& cloud) {
  if (cloud.points_m.cols() < 1) throw std::invalid_argument("ImplicitSurface: a surface needs samples");
  const std::vector<Index> order = SampleBlocks::order(cloud.points_m);
  return {cloud.points_m(Eigen::all, order), cloud.normals(Eigen::all, order)};
}

double default_support_m(const PointCloud& cloud) {
  // 2.2 spacings reach about 15 samples: enough to average, few enough to stay local.
  return 2.2 * sample_spacing_m(cloud);
}

}  // namespace

ImplicitSurface::ImplicitSurface(const PointCloud& cloud) : ImplicitSurface(cloud, default_support_m(cloud)) {}

ImplicitSurface::ImplicitSurface(const PointCloud& cloud, double support_m)
    : cloud_(in_block_order(cloud)), blocks_(cloud_), support_m_(support_m) {
  if (!(support_m > 0.0) || !std::isfinite(support_m)) {
    throw std::invalid_argument("ImplicitSurface: the support must be finite and greater than zero");
  }
  bounds_ = {Vector3d(cloud_.points_m.rowwise().minCoeff()), Vector3d(cloud_.points_m.rowwise().maxCoeff())};
  fill_clearances();
  fill_starts();
}

void ImplicitSurface::allow_error(double error_m, double depth_m) {
  patches_.reset();
  if (!(error_m > 0.0)) return;
  patches_.emplace(support_m_, error_m, depth_m, starts_.size());
  for (const Start& start : starts_) patches_->add(blocks_, start.plane.a_m, start.plane.n);
}

void ImplicitSurface::fill_starts() {
  starts_.reserve(cloud_.points_m.cols());
  bends_.reserve(cloud_.points_m.cols());
  for (Index i = 0; i < cloud_.points_m.cols(); ++i) {
    // A sample weighs 1 in its own plane: there is one, unless its normal is none.
    const std::optional<Plane> plane = fit(point_m(i), cloud_.normals.col(i));
    if (!plane) throw std::invalid_argument("ImplicitSurface: normals must be of length one");
    const Vector3d n = plane->n;
    Lanes cosine = Lanes::Ones();
    const double radius_m = (1.0 + kStray) * support_m_;
    blocks_.for_each_near(plane->a_m, radius_m, [&](const Block& block, Index) {
      const Lanes from_n = block.cosines(n), squared = block.squared_distances(plane->a_m);
      const auto counts = from_n > kUnlike - kRounding && squared < radius_m * radius_m;
      cosine = cosine.min(counts.select(from_n, 1.0));
    });
    const double least = std::clamp(cosine.minCoeff() - kRounding, 0.0, 1.0);
    starts_.push_back({*plane, least, clear_m(i, *plane, least)});
    bends_.push_back(bend_at(i, kUnlike));
  }
}

/// Tests whether a face ends where it meets another one's plane: each lies behind the other's, and no sample of the
/// face within reach is before it, or only by the hollowness of the other one, the wall of a hole.
bool ImplicitSurface::ends_at(const Plane& other, double hollow_per_m, const Plane& face, const Vector3d& p_m,
                              double reach_m) const {
  constexpr double kSame = 0.9, kRoom = 0.02, kBefore = 0.35;
  const Vector3d way = other.a_m - face.a_m;
  const double room_m = kRoom * way.norm();
  if (face.n.dot(way) > room_m || other.n.dot(way) < -room_m) return false;
  bool ends = true;
  blocks_.for_each_near(p_m, reach_m, [&](const Block& block, Index) {
    for (int k = 0; k < SampleBlocks::kLanes; ++k) {
      const Vector3d s_m = block.point_m(k);
      const bool is_own =
          block.normal(k).dot(face.n) > kSame && std::abs(face.n.dot(s_m - face.a_m)) < kBefore * support_m_;
      const double before_m = kBefore * support_m_ + 0.5 * hollow_per_m * (s_m - other.a_m).squaredNorm();
      if (is_own && (s_m - p_m).norm() < reach_m && other.n.dot(s_m - other.a_m) > before_m) ends = false;
    }
  });
  return ends;
}

void ImplicitSurface::find_edges(double reach_m, const std::function<bool(Index, Index)>& are_one) {
  const auto is_bent = [&](Index i) { return bends_[i].most_per_m() * reach_m > kMostTurn_rad; };
  forget_edges();
  beside_.assign(starts_.size(), {});
  for (Index i = 0; i < std::ssize(starts_); ++i) {
    if (is_bent(i) && !are_one) continue;
    std::array<Vector3d, kMostBeside + 1> seen = {starts_[i].plane.n};
    std::size_t looked = 1;
    while (looked <= kMostBeside) {
      const Index other = nearest_unlike(point_m(i), point_m(i), reach_m, {seen.data(), looked}, kUnlike);
      if (other < 0) break;
      seen[looked++] = cloud_.normals.col(other);
      if (are_one ? are_one(i, other) : is_bent(other)) continue;
      const double hollow_per_m = std::max(0.0, -bends_[other].k2_per_m);
      if (!ends_at(starts_[other].plane, hollow_per_m, starts_[i].plane, point_m(i), reach_m)) continue;
      beside_[i].samples[beside_[i].count++] = other;
    }
  }
  if (!are_one) find_blunt_edges(reach_m);
  for (Index i = 0; i < std::ssize(starts_); ++i) drop_unmet(i, reach_m);
}

void ImplicitSurface::forget_edges() {
  for (const Blunted& was : blunted_) {
    starts_[was.sample] = was.start;
    bends_[was.sample] = was.bend;
  }
  blunted_.clear();
  beside_.clear();
}

/// Finds edges over which normals turn by 20 to 60 degrees: chamfers, and the sides of prisms.
void ImplicitSurface::find_blunt_edges(double reach_m) {
  constexpr std::size_t kMostLooks = 10;
  std::vector<char> at_edge(starts_.size());
  for (Index i = 0; i < std::ssize(starts_); ++i) at_edge[i] = is_at_edge(i) ? 1 : 0;
  std::vector<Index> blunt;
  for (Index i = 0; i < std::ssize(starts_); ++i) {
    Beside& found = beside_[i];
    std::array<Vector3d, kMostLooks + kMostBeside + 1> seen = {cloud_.normals.col(i)};
    std::size_t looked = 1;
    for (std::size_t k = 0; k < found.count; ++k) seen[looked++] = cloud_.normals.col(found.samples[k]);
    const std::size_t known = looked;
    while (looked < known + kMostLooks && found.count < kMostBeside) {
      const Index other = nearest_unlike(point_m(i), point_m(i), reach_m, {seen.data(), looked}, kBlunt, at_edge);
      if (other < 0) break;
      seen[looked++] = cloud_.normals.col(other);
      if (is_blunt_end(i, other, reach_m)) found.samples[found.count++] = other;
    }
    for (std::size_t k = 0; k < found.count; ++k) {
      const Index other = found.samples[k];
      if (cloud_.normals.col(other).dot(cloud_.normals.col(i)) > kUnlike) blunt.insert(blunt.end(), {i, other});
    }
  }
  for (const Index i : blunt) {
    if (starts_[i].is_sharp) continue;  // It is there once for each face beside it.
    const auto plane = fit(point_m(i), cloud_.normals.col(i), true);
    if (!plane) continue;
    blunted_.push_back({i, starts_[i], bends_[i]});
    starts_[i].plane = *plane;
    starts_[i].plane.least_cosine = 0.0;  // Here no patch knows the surface.
    starts_[i].is_sharp = true;
    bends_[i] = bend_at(i, kBlunt);
  }
}

/// Tests whether the face of a sample ends at that of another one, both from the samples within 20 degrees of theirs.
bool ImplicitSurface::is_blunt_end(Index sample, Index other, double reach_m) const {
  const SurfaceBend own = bend_at(sample, kBlunt), across = bend_at(other, kBlunt);
  // A hollow face does not end by itself.
  if (std::max(own.k1_per_m, across.k1_per_m) * reach_m > kMostTurn_rad) return false;
  const auto face = fit(point_m(sample), cloud_.normals.col(sample), true),
             end = fit(point_m(other), cloud_.normals.col(other), true);
  return face && end && ends_at(*end, std::max(0.0, -across.k2_per_m), *face, point_m(sample), reach_m);
}

/// Tests whether the samples around one belong to two faces that meet: each has others that are like it.
bool ImplicitSurface::is_at_edge(Index sample) const {
  constexpr double kReach = 0.7, kAlike = 0.99;
  struct Near {
    Vector3d p_m, n;
  };
  std::vector<Near> around;
  const Vector3d p_m = point_m(sample);
  blocks_.for_each_near(p_m, kReach * support_m_, [&](const Block& block, Index) {
    for (int k = 0; k < SampleBlocks::kLanes; ++k) {
      const Near near{block.point_m(k), block.normal(k)};
      if ((near.p_m - p_m).norm() < kReach * support_m_) around.push_back(near);
    }
  });
  const auto has_like = [&](const Near& one) {
    return std::ranges::any_of(
        around, [&](const Near& other) { return other.n.dot(one.n) > kAlike && (other.p_m - one.p_m).norm() > 0.0; });
  };
  const Vector3d n = cloud_.normals.col(sample);
  return has_like({p_m, n}) &&
         std::ranges::any_of(around, [&](const Near& one) { return one.n.dot(n) < kBlunt && has_like(one); });
}

/// Drops the faces beside a sample that meet neither its own nor another one within reach: a thin plate's back is
/// beside its front only near a side.
void ImplicitSurface::drop_unmet(Index i, double reach_m) {
  const auto meet = [&](Index a, Index b) {
    const Plane &first = starts_[a].plane, &second = starts_[b].plane;
    const double cosine = first.n.dot(second.n), sine2 = 1.0 - cosine * cosine;
    const double h1_m = first.n.dot(point_m(i) - first.a_m), h2_m = second.n.dot(point_m(i) - second.a_m);
    return h1_m * h1_m + h2_m * h2_m - 2.0 * cosine * h1_m * h2_m < reach_m * reach_m * sine2;
  };
  const Beside all = beside_[i];
  const std::span<const Index> others(all.samples.data(), all.count);
  beside_[i].count = 0;
  for (const Index one : others) {
    if (meet(one, i) || std::ranges::any_of(others, [&](Index other) { return other != one && meet(one, other); })) {
      beside_[i].samples[beside_[i].count++] = one;
    }
  }
}

SurfaceBend ImplicitSurface::bend_at(Index sample, double unlike) const {
  const Vector3d p_m = point_m(sample), n = cloud_.normals.col(sample);
  BendFit fit(p_m, n, support_m_);
  blocks_.for_each_near(p_m, support_m_, [&](const Block& block, Index number) {
    for (int k = 0; k < SampleBlocks::kLanes; ++k) {
      if (SampleBlocks::kLanes * number + k == sample || block.cosines(n)[k] < unlike) continue;
      fit.add(block.point_m(k), block.normal(k));
    }
  });
  return fit.bend();
}

/// Returns a radius around a sample without normals unlike that of any second projection near it: 0 where none is
/// known. Normals are compared with the mean of its block's, from which they must not differ by more than 45 degrees.
double ImplicitSurface::clear_m(Index sample, const Plane& plane, double least_cosine) const {
  const BlockClearance& block = clearances_[sample / SampleBlocks::kLanes];
  // A second projection turns from the first by an angle of this cosine at most, and the first from the block's mean:
  // 15 degrees together leave the 60 degrees of what is unlike.
  const double turn = std::acos(std::min(1.0, least_cosine)) + std::acos(std::min(1.0, block.axis.dot(plane.n)));
  if (!(turn < std::numbers::pi / 12.0 - 1e-6)) return 0.0;
  return std::max(0.0, block.clear_m - (point_m(sample) - block.centre_m).norm() - kRounding);
}

void ImplicitSurface::fill_clearances() {
  // Beyond this other faces are looked for, whether there are any or not: see distance_from().
  const double farthest_m = 8.0 * support_m_;
  clearances_.reserve(blocks_.blocks().size());
  for (const Block& own : blocks_.blocks()) {
    BlockClearance clearance{own.point_m(0), Vector3d(own.n_x.sum(), own.n_y.sum(), own.n_z.sum()), farthest_m};
    clearance.axis.normalize();
    blocks_.for_each_near(clearance.centre_m, farthest_m, [&](const Block& block, Index) {
      // Unused lanes have no normal, and lie far away.
      const Lanes squared = (block.cosines(clearance.axis) < std::numbers::sqrt2 / 2.0)
                                .select(block.squared_distances(clearance.centre_m), farthest_m * farthest_m);
      clearance.clear_m = std::min(clearance.clear_m, std::sqrt(squared.minCoeff()));
    });
    clearances_.push_back(clearance);
  }
}

/// Finds the sample nearest to x among those within the radius of c whose normals are unlike all of `seen`, or -1;
/// among all, or those whose mark in `of` is not 0.
Index ImplicitSurface::nearest_unlike(const Vector3d& x_m, const Vector3d& c_m, double radius_m,
                                      std::span<const Vector3d> seen, double unlike,
                                      std::span<const char> of) const noexcept {
  Index found = -1;
  double best_squared = std::numeric_limits<double>::infinity();
  blocks_.for_each_near(c_m, radius_m, [&](const Block& block, Index number) {
    const Lanes squared = block.squared_distances(x_m), from_c = block.squared_distances(c_m);
    Lanes cosine = block.cosines(seen[0]);
    for (const Vector3d& n : seen.subspan(1)) cosine = cosine.max(block.cosines(n));
    for (int k = 0; k < SampleBlocks::kLanes; ++k) {
      if (cosine[k] >= unlike || from_c[k] >= radius_m * radius_m || squared[k] >= best_squared) continue;
      if (!of.empty() && of[SampleBlocks::kLanes * number + k] == 0) continue;
      best_squared = squared[k];
      found = SampleBlocks::kLanes * number + k;
    }
  });
  return found;
}

/// Fits the plane a(c), n(c); nothing if no sample near c has a normal like the reference.
std::optional<ImplicitSurface::Plane> ImplicitSurface::fit(const Vector3d& c_m, const Vector3d& n_reference,
                                                           bool is_sharp) const noexcept {
  const double from = is_sharp ? kBlunt : kUnlike, rise = 1.0 / (1.0 - from), zero = from * rise;
  const double inv_h2 = 1.0 / (support_m_ * support_m_);
  Lanes sum = Lanes::Zero(), a_x = sum, a_y = sum, a_z = sum, n_x = sum, n_y = sum, n_z = sum;
  Lanes squares = sum, turns = sum;
  Lanes least_cosine = Lanes::Ones();
  blocks_.for_each_near(c_m, support_m_, [&](const Block& block, Index) {
    const Lanes x = block.x - c_m.x(), y = block.y - c_m.y(), z = block.z - c_m.z();
    const Lanes squared = x.square() + y.square() + z.square();
    const Lanes near = (1.0 - squared * inv_h2).max(0.0);
    const Lanes cosine = block.cosines(n_reference);
    const Lanes th = (near * (rise * cosine - zero).max(0.0)).square().square();
    sum += th;
    a_x += th * x;
    a_y += th * y;
    a_z += th * z;
    n_x += th * block.n_x;
    n_y += th * block.n_y;
    n_z += th * block.n_z;
    squares += (th > 0.0).select(th * squared, 0.0);
    turns += (th > 0.0).select(th * (x * block.n_x + y * block.n_y + z * block.n_z), 0.0);
    least_cosine = least_cosine.min((near > 0.0).select(cosine, 1.0));
  });
  const double weight = sum.sum();
  // At the rim of the support 1 - d^2/h^2 is rounding below 1e-3, to the fourth power 1e-12.
  if (!(weight > 1e-12)) return std::nullopt;
  using Lane = Eigen::Array<double, 1, 1>;
  const auto mean = [&](const Lanes& lanes, double unit) { return Lane(lanes.sum() / (weight * unit)); };
  const double h = support_m_;
  const PlaneOver<Lane> plane =
      touching_plane<Lane>({mean(a_x, h), mean(a_y, h), mean(a_z, h), mean(n_x, 1.0), mean(n_y, 1.0), mean(n_z, 1.0),
                            mean(squares, h * h), mean(turns, h)});
  const Vector3d n(plane.n_x.value(), plane.n_y.value(), plane.n_z.value());
  // In the middle of the samples, not over c, which may be past an edge.
  const Vector3d middle_m = Vector3d(a_x.sum(), a_y.sum(), a_z.sum()) / weight;
  return Plane{c_m + middle_m + (h * plane.height.value() - n.dot(middle_m)) * n, n, least_cosine.minCoeff()};
}

/// Projects x twice, from a sample on.
ImplicitSurface::Face ImplicitSurface::project(const Vector3d& x_m, Index start) const noexcept {
  const Plane& first = starts_[start].plane;
  // At an edge it counts where the samples near x are.
  if (patches_ && first.least_cosine >= kUnlike) {
    if (const auto near = patches_->project(x_m, start, first.a_m, first.n)) return {first.a_m, near->n, near->f_m};
  }
  const double f_m = first.n.dot(x_m - first.a_m);
  const std::optional<Plane> second = fit(x_m - f_m * first.n, first.n, starts_[start].is_sharp);
  // Past an edge or over a hole the projection leaves the samples: the first plane, extended, is the face.
  if (!second) return {first.a_m, first.n, f_m};
  return {second->a_m, second->n, second->n.dot(x_m - second->a_m)};
}

std::optional<SurfaceDistance> ImplicitSurface::distance(const Vector3d& x_m, double reach_m) const noexcept {
  const Index start = nearest(x_m, reach_m).sample;
  if (start < 0) return std::nullopt;
  return distance_from(x_m, start);
}

SurfaceDistance ImplicitSurface::face_distance(const Vector3d& x_m, Index sample) const noexcept {
  const Face face = project(x_m, sample);
  return {face.f_m, x_m - face.f_m * face.n, face.n};
}

/// Tests that no face matters other than the one on which x is projected from this sample, with f and n.
bool ImplicitSurface::is_alone(const Vector3d& x_m, Index start, double f_m, const Vector3d& n) const noexcept {
  if (starts_[start].plane.least_cosine < kUnlike) return false;
  if (f_m > -kDeep * support_m_) return true;
  const double way_m = (x_m - point_m(start)).norm();
  return is_clear(start, n, way_m + widest_m(way_m));
}

SurfaceDistance ImplicitSurface::distance_from(const Vector3d& x_m, Index start) const noexcept {
  const Face first = project(x_m, start);
  if (is_alone(x_m, start, first.f_m, first.n)) return {first.f_m, x_m - first.f_m * first.n, first.n};
  return of_several_faces(x_m, start, first);
}

SurfaceDistance ImplicitSurface::of_several_faces(const Vector3d& x_m, Index start, const Face& first) const noexcept {
  // Near an edge the nearest sample may lie on either side. Deep inside, another face may be as near as this one: but
  // for the slant to the nearest sample, d^2/2|f| < h/4 where d < h/2.
  const double way_m = (x_m - point_m(start)).norm();
  const bool at_edge = starts_[start].plane.least_cosine < kUnlike, deep = first.f_m < -0.75 * support_m_;
  const bool inside = first.f_m < 0.0;
  double radius_m = inside ? widest_m(way_m) : support_m_;
  Face face = first;
  double edge_m = support_m_;
  std::array<Face, kMostFaces> convex = {first};
  std::size_t count = 1;
  std::array<Vector3d, kMostFaces> seen = {first.n};
  const double unlike = starts_[start].is_sharp ? kBlunt : kUnlike;
  for (std::size_t faces = 1; faces < kMostFaces; ++faces) {
    const Index beyond = nearest_unlike(x_m, inside ? x_m : point_m(start), radius_m, {seen.data(), faces}, unlike);
    if (beyond < 0) break;
    const Face next = project(x_m, beyond);
    seen[faces] = next.n;
    // The rim of a thin plate is a single row of samples, which may be wide apart.
    if (first.n.dot(next.n) < -kUnlike) edge_m = 2.0 * support_m_;
    radius_m = std::max(radius_m, edge_m);
    // Convex: each face lies behind the other's plane.
    const bool meets_convexly = (face.n - next.n).dot(next.a_m - face.a_m) < 0.0;
    if (meets_convexly) convex[count++] = next;
    // None is farther outside than the nearest sample, and a point deep inside is inside: a plane that says otherwise
    // is that of a part farther off.
    const double most_m = at_edge && !deep ? way_m + 0.2 * support_m_ : 0.0;
    const bool near = (x_m - point_m(beyond)).norm() < way_m + 0.25 * support_m_ ||
                      (at_edge && !deep && (point_m(start) - point_m(beyond)).norm() < edge_m);
    if (!near || next.f_m > most_m) continue;
    if (meets_convexly ? next.f_m > face.f_m : next.f_m < face.f_m) face = next;
  }
  const Vector3d n = face.f_m < 0.0 ? mean_normal(face, {convex.data(), count}) : face.n;
  return {face.f_m, x_m - face.f_m * n, n, n == first.n};
}

/// Returns the normal inside an edge: the mean of those of the faces nearly as near as the nearest one, up to twice as
/// far, so that it turns gradually as x moves from one to the other. Opposite faces, of a plate, do not count.
Vector3d ImplicitSurface::mean_normal(const Face& face, std::span<const Face> convex) noexcept {
  Vector3d others = Vector3d::Zero();
  for (const Face& other : convex) {
    const double farther = other.f_m / face.f_m;
    if (other.n != face.n && farther >= 1.0 && farther < 2.0 && other.n.dot(face.n) >= -kUnlike) {
      others += (2.0 - farther) * other.n;
    }
  }
  if (others.isZero(0.0)) return face.n;
  const Vector3d sum = face.n + others;
  // Samples that are no surface may have any normals.
  return sum.squaredNorm() > 0.01 ? sum.normalized() : face.n;
}

ImplicitSurface::Estimate ImplicitSurface::estimate(const Vector3d& x_m, Index sample) const noexcept {
  const Start& start = starts_[sample];
  if (!patches_ || start.plane.least_cosine < kUnlike) return {};
  const Estimate estimate = patches_->estimate(x_m, sample, start.plane.a_m, start.plane.n);
  // Deep inside, faces that meet this one concavely could be nearer, if there are others.
  if (estimate.least_m < -kDeep * support_m_) return {};
  return estimate;
}

}  // namespace thenar
