#include "collision/implicit_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// Where unused lanes are [m]: beyond any support, and the square is finite.
constexpr double kFarAway = 1e30;

// Normals more than 60 degrees apart belong to two faces; less is curvature, or noise. 60 degrees is where a sample's
// weight ends: max(0, 2 cos - 1).
constexpr double kUnlike = 0.5;

PointCloud in_tree_order(const PointCloud& cloud, Index leaves) {
  const SphereTree tree(cloud, leaves);
  return {cloud.points_m(Eigen::all, tree.order()), cloud.normals(Eigen::all, tree.order())};
}

double default_support_m(const PointCloud& cloud) {
  // 2.2 spacings reach about 15 samples: enough to average, few enough to stay local.
  return 2.2 * sample_spacing_m(cloud);
}

}  // namespace

ImplicitSurface::ImplicitSurface(const PointCloud& cloud, Index leaves)
    : ImplicitSurface(cloud, leaves, default_support_m(cloud)) {}

ImplicitSurface::ImplicitSurface(const PointCloud& cloud, Index leaves, double support_m)
    : cloud_(in_tree_order(cloud, leaves)), tree_(cloud_, leaves), support_m_(support_m) {
  if (!(support_m > 0.0) || !std::isfinite(support_m)) {
    throw std::invalid_argument("ImplicitSurface: the support must be finite and greater than zero");
  }
  bounds_ = {Vector3d(cloud_.points_m.rowwise().minCoeff()), Vector3d(cloud_.points_m.rowwise().maxCoeff())};
  fill_blocks();
}

void ImplicitSurface::fill_blocks() {
  const auto lanes = [](const auto& row, Index begin, Index n, double unused) {
    Lanes filled = Lanes::Constant(unused);
    filled.head(n) = row.segment(begin, n).transpose();
    return filled;
  };
  const auto &p = cloud_.points_m, &n = cloud_.normals;
  for (const Index leaf : tree_.leaves()) {
    const SphereTree::Node& node = tree_.nodes()[leaf];
    first_block_.push_back(static_cast<Index>(blocks_.size()));
    for (Index i = node.begin; i < node.end; i += kLanes) {
      const Index used = std::min<Index>(kLanes, node.end - i);
      blocks_.push_back({lanes(p.row(0), i, used, kFarAway), lanes(p.row(1), i, used, 0.0),
                         lanes(p.row(2), i, used, 0.0), lanes(n.row(0), i, used, 0.0), lanes(n.row(1), i, used, 0.0),
                         lanes(n.row(2), i, used, 0.0)});
    }
  }
  first_block_.push_back(static_cast<Index>(blocks_.size()));
}

/// Calls visit(block) for every leaf that may hold samples within the radius of c, left before right.
template <typename Visit>
void ImplicitSurface::for_each_block(const Vector3d& c_m, double radius_m, Visit visit) const {
  std::array<Index, SphereTree::kMaxDepth> stack;
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const SphereTree::Node& node = tree_.nodes()[stack[--depth]];
    const double touching_m = node.radius_m + radius_m;
    if ((node.centre_m - c_m).squaredNorm() > touching_m * touching_m) continue;
    if (node.is_leaf()) {
      for (Index b = first_block_[node.right]; b < first_block_[node.right + 1]; ++b) visit(blocks_[b]);
    } else {
      stack[depth++] = node.right;
      stack[depth++] = node.left;
    }
  }
}

/// The sample nearest to x, by branch and bound.
std::optional<ImplicitSurface::Sample> ImplicitSurface::nearest(const Vector3d& x_m, double reach_m) const noexcept {
  struct Visit {
    Index node;
    double least_m;  // no sample of the node is nearer
  };
  const auto visit = [&](Index id) {
    const SphereTree::Node& node = tree_.nodes()[id];
    return Visit{id, (node.centre_m - x_m).norm() - node.radius_m};
  };

  double best_m = reach_m, best_squared = reach_m * reach_m;
  const Block* best_block = nullptr;
  int best_lane = 0;
  std::array<Visit, SphereTree::kMaxDepth> stack;
  int depth = 0;
  stack[depth++] = visit(0);
  while (depth > 0) {
    const Visit top = stack[--depth];
    if (!(top.least_m <= best_m)) continue;
    const SphereTree::Node& node = tree_.nodes()[top.node];
    if (!node.is_leaf()) {
      // The nearer child first: what it finds prunes the other.
      Visit near = visit(node.left), far = visit(node.right);
      if (far.least_m < near.least_m) std::swap(near, far);
      stack[depth++] = far;
      stack[depth++] = near;
      continue;
    }
    for (Index b = first_block_[node.right]; b < first_block_[node.right + 1]; ++b) {
      const Lanes squared = blocks_[b].squared_distances(x_m);
      const double least = squared.minCoeff();
      if (!(least <= best_squared)) continue;
      best_squared = least;
      best_m = std::sqrt(least);
      best_block = &blocks_[b];
      best_lane = 0;
      while (squared[best_lane] > least) ++best_lane;
    }
  }
  if (best_block == nullptr) return std::nullopt;
  return best_block->sample(best_lane);
}

/// The sample nearest to x among those within the radius of c whose normals are unlike all of `seen`.
std::optional<ImplicitSurface::Sample> ImplicitSurface::nearest_unlike(const Vector3d& x_m, const Vector3d& c_m,
                                                                       double radius_m,
                                                                       std::span<const Vector3d> seen) const noexcept {
  std::optional<Sample> found;
  double best_squared = std::numeric_limits<double>::infinity();
  for_each_block(c_m, radius_m, [&](const Block& block) {
    const Lanes squared = block.squared_distances(x_m), from_c = block.squared_distances(c_m);
    Lanes cosine = block.cosines(seen[0]);
    for (const Vector3d& n : seen.subspan(1)) cosine = cosine.max(block.cosines(n));
    for (int k = 0; k < kLanes; ++k) {
      if (cosine[k] >= kUnlike || from_c[k] >= radius_m * radius_m || squared[k] >= best_squared) continue;
      best_squared = squared[k];
      found = block.sample(k);
    }
  });
  return found;
}

/// The plane a(c), n(c), seen from x. Nothing if no sample near c has a normal like the reference.
std::optional<ImplicitSurface::Face> ImplicitSurface::fit(const Vector3d& x_m, const Vector3d& c_m,
                                                          const Vector3d& n_reference) const noexcept {
  const double inv_h2 = 1.0 / (support_m_ * support_m_);
  Lanes sum = Lanes::Zero(), a_x = sum, a_y = sum, a_z = sum, n_x = sum, n_y = sum, n_z = sum;
  Lanes least_cosine = Lanes::Ones();
  for_each_block(c_m, support_m_, [&](const Block& block) {
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
  const Vector3d n = Vector3d(n_x.sum(), n_y.sum(), n_z.sum()).normalized();
  return Face{a_m, n, n.dot(x_m - a_m), weight, least_cosine.minCoeff()};
}

/// Projects x twice, from `start` on. The weight and the least cosine are those around the start.
std::optional<ImplicitSurface::Face> ImplicitSurface::project(const Vector3d& x_m, const Sample& start) const noexcept {
  std::optional<Face> first = fit(x_m, start.point_m, start.normal);
  if (!first) return std::nullopt;
  const std::optional<Face> second = fit(x_m, x_m - first->f_m * first->n, first->n);
  // Past an edge or over a hole the projection leaves the samples: the first plane, extended, is the face.
  if (!second) return first;
  return Face{second->a_m, second->n, second->f_m, first->weight, first->least_cosine};
}

std::optional<SurfaceDistance> ImplicitSurface::distance(const Vector3d& x_m, double reach_m) const noexcept {
  const std::optional<Sample> start = nearest(x_m, reach_m);
  if (!start) return std::nullopt;
  std::optional<Face> face = project(x_m, *start);
  if (!face) return std::nullopt;

  // Near an edge the nearest sample may lie on either side. Deep inside, another face may be as near as this one: but for
  // the slant to the nearest sample, d^2/2|f| < h/4 where d < h/2.
  const bool deep = face->f_m < -0.75 * support_m_;
  if (deep || face->least_cosine < kUnlike) {
    const Vector3d& view_m = deep ? x_m : start->point_m;
    double radius_m = deep ? (x_m - start->point_m).norm() + 0.25 * support_m_ : support_m_;
    // At a corner three faces meet, at that of a plate four.
    std::array<Vector3d, 4> seen = {face->n};
    for (std::size_t faces = 1; faces < seen.size(); ++faces) {
      const std::optional<Sample> beyond = nearest_unlike(x_m, view_m, radius_m, {seen.data(), faces});
      const std::optional<Face> next = beyond ? project(x_m, *beyond) : std::nullopt;
      if (!next) break;
      seen[faces] = next->n;
      // The rim of a thin plate is a single row of samples, which may be wide apart.
      if (seen[0].dot(next->n) < -kUnlike) radius_m = 2.0 * support_m_;
      // Convex: each face lies behind the other's plane.
      const bool convex = (face->n - next->n).dot(next->a_m - face->a_m) < 0.0;
      if (convex ? next->f_m > face->f_m : next->f_m < face->f_m) face = next;
    }
  }
  return SurfaceDistance{face->f_m, x_m - face->f_m * face->n, face->n};
}

}  // namespace thenar
