#include "collision/sphere_tree.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

struct Sphere {
  Vector3d centre_m;
  double radius_m;
};

/// The samples of one node.
struct Samples {
  const Eigen::Matrix3Xd& points_m;
  const Index* first;
  const Index* last;

  /// The one farthest from c, or nearest: the first such one in the node's order.
  [[nodiscard]] Index farthest(const Vector3d& c) const {
    return *std::max_element(first, last, [&](Index i, Index j) { return squared(i, c) < squared(j, c); });
  }
  [[nodiscard]] Index nearest(const Vector3d& c) const {
    return *std::min_element(first, last, [&](Index i, Index j) { return squared(i, c) < squared(j, c); });
  }
  [[nodiscard]] double squared(Index i, const Vector3d& c) const { return (points_m.col(i) - c).squaredNorm(); }

  [[nodiscard]] Vector3d mean() const {
    Vector3d sum = Vector3d::Zero();
    for (const Index* i = first; i != last; ++i) sum += points_m.col(*i);
    return sum / static_cast<double>(last - first);
  }

  /// The smallest sphere about c that contains them.
  [[nodiscard]] Sphere around(const Vector3d& c) const { return {c, (points_m.col(farthest(c)) - c).norm()}; }
};

/// The smallest sphere that contains a and b.
Sphere merge(const Sphere& a, const Sphere& b) {
  const Vector3d between = b.centre_m - a.centre_m;
  const double distance = between.norm();
  if (distance + b.radius_m <= a.radius_m) return a;
  if (distance + a.radius_m <= b.radius_m) return b;
  const double radius = 0.5 * (distance + a.radius_m + b.radius_m);
  return {a.centre_m + (radius - a.radius_m) / distance * between, radius};
}

/// Ritter's sphere: on two samples far apart, grown over those outside [Ritter 1990].
Sphere ritter(const Samples& samples) {
  const Vector3d a = samples.points_m.col(samples.farthest(samples.points_m.col(*samples.first)));
  const Vector3d b = samples.points_m.col(samples.farthest(a));
  Sphere sphere{0.5 * (a + b), 0.5 * (b - a).norm()};
  for (const Index* i = samples.first; i != samples.last; ++i) {
    sphere = merge(sphere, {samples.points_m.col(*i), 0.0});
  }
  return samples.around(sphere.centre_m);
}

Sphere smaller(const Sphere& a, const Sphere& b) { return a.radius_m <= b.radius_m ? a : b; }

}  // namespace

SphereTree::SphereTree(const PointCloud& cloud, Index leaves) : order_(cloud.points_m.cols()) {
  if (leaves < 1 || leaves > cloud.points_m.cols()) {
    throw std::invalid_argument("SphereTree: leaves must be between 1 and the number of points");
  }
  std::iota(order_.begin(), order_.end(), Index{0});
  nodes_.reserve(2 * leaves - 1);
  leaves_.reserve(leaves);
  build(cloud.points_m, 0, cloud.points_m.cols(), leaves);
}

Index SphereTree::build(const Eigen::Matrix3Xd& points_m, Index begin, Index end, Index leaves) {
  const auto id = static_cast<Index>(nodes_.size());
  Node node{Vector3d::Zero(), 0.0, begin, end, -1, -1, -1};
  nodes_.push_back(node);  // takes the number; filled in below
  const Samples samples{points_m, order_.data() + begin, order_.data() + end};

  // Children first: they settle the order of the samples, on which ties and the mean's last bits depend.
  Sphere sphere{};
  if (leaves == 1) {
    std::sort(order_.begin() + begin, order_.begin() + end);
    node.right = static_cast<Index>(leaves_.size());
    leaves_.push_back(id);
    sphere = samples.around(samples.mean());
  } else {
    const Index middle = split(points_m, begin, end, leaves);
    node.left = build(points_m, begin, middle, leaves / 2);
    node.right = build(points_m, middle, end, leaves - leaves / 2);
    const Node &a = nodes_[node.left], &b = nodes_[node.right];
    sphere = samples.around(merge({a.centre_m, a.radius_m}, {b.centre_m, b.radius_m}).centre_m);
  }

  sphere = smaller(sphere, ritter(samples));
  node.centre_m = sphere.centre_m;
  node.radius_m = sphere.radius_m;
  node.representative = samples.nearest(samples.mean());
  nodes_[id] = node;
  return id;
}

Index SphereTree::split(const Eigen::Matrix3Xd& points_m, Index begin, Index end, Index leaves) {
  Eigen::AlignedBox3d box;
  for (Index k = begin; k < end; ++k) box.extend(Vector3d(points_m.col(order_[k])));
  Index axis = 0;
  box.sizes().maxCoeff(&axis);

  const Index middle = begin + (end - begin) * (leaves / 2) / leaves;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](Index i, Index j) {
    const double x_i = points_m(axis, i), x_j = points_m(axis, j);
    return x_i < x_j || (x_i == x_j && i < j);
  });
  return middle;
}

}  // namespace thenar
