// SPDX-License-Identifier: Apache-2.0
#include "collision/solids/sampled_solid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/point_grid.h"
#include "collision/surface_bend.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// In spacings: range of samples for the curvature, and distance from an edge to its faces' samples.
constexpr double kBends = 2.0, kBeside = 2.5;
// Normals that differ by 60 degrees are of two faces, as in ImplicitSurface; those of a plate's two sides do not meet.
constexpr double kUnlike = 0.5, kOpposite = -0.95;
// In spacings: distance of an edge's points, and range along it of others for its straightness.
constexpr double kApart = 0.5, kEdgeTells = 4.0;
constexpr double kBent_m = 1e-8;  // Less is straight, or flat.

/// The height of x over the surface around a sample, and its gradient.
struct Height {
  double over_m;
  Vector3d slope;
};

Height height(const BentSample& at, const Vector3d& x) {
  const Vector3d way = x - at.p_m, t2 = at.t2();
  const double u1 = way.dot(at.t1), u2 = way.dot(t2);
  return {at.n.dot(way) + 0.5 * (at.k1_per_m * u1 * u1 + at.k2_per_m * u2 * u2),
          at.n + at.k1_per_m * u1 * at.t1 + at.k2_per_m * u2 * t2};
}

/// Fits a sample's curvatures to its neighbours' normals and heights; less than `flat_per_m` is flat.
void bend(const PointCloud& cloud, const PointGrid& grid, Index i, double spacing_m, double flat_per_m,
          BentSample& sample) {
  BendFit fit(sample.p_m, sample.n, kBends * spacing_m);
  grid.for_each_neighbour(i, [&](Index j, double) {
    if (cloud.normals.col(j).dot(sample.n) >= kUnlike) fit.add(cloud.points_m.col(j), cloud.normals.col(j));
  });
  const SurfaceBend bend = fit.bend();
  const auto or_flat = [&](double k_per_m) { return std::abs(k_per_m) < flat_per_m ? 0.0 : k_per_m; };
  sample.t1 = bend.t1;
  sample.k1_per_m = or_flat(bend.k1_per_m);
  sample.k2_per_m = or_flat(bend.k2_per_m);
}

/// Finds the intersection of the surfaces around two or three samples nearest to `x`. Newton's method.
Vector3d meeting(const BentSample& a, const BentSample& b, const BentSample* c, Vector3d x) {
  for (int k = 0; k < 5; ++k) {
    const Height at_a = height(a, x), at_b = height(b, x);
    const Vector3d along = at_a.slope.cross(at_b.slope);
    Matrix3d G;
    G << at_a.slope.transpose(), at_b.slope.transpose(), along.transpose();
    Vector3d over(at_a.over_m, at_b.over_m, 0.0);
    if (c != nullptr) {
      const Height at_c = height(*c, x);
      G.row(2) = at_c.slope;
      over[2] = at_c.over_m;
    }
    x -= G.inverse() * over;
  }
  return x;
}

bool is_convex(const BentSample& a, const BentSample& b) {
  const Vector3d way = b.p_m - a.p_m;
  return a.n.dot(way) < 0.0 && b.n.dot(way) > 0.0;
}

bool are_of_two_faces(const BentSample& a, const BentSample& b) {
  const double cosine = a.n.dot(b.n);
  return cosine < kUnlike && cosine > kOpposite && is_convex(a, b);
}

struct SharpPlaces {
  std::vector<SharpPoint> corners, edges;
};

/// Finds the points of an edge and of a corner nearest to sample i.
void find_sharp(const std::vector<BentSample>& samples, const PointGrid& grid, Index i, double spacing_m,
                SharpPlaces& found) {
  const BentSample& own = samples[i];
  struct Other {
    const BentSample* sample;
    double distance_m;
  };
  std::vector<Other> others;
  grid.for_each_neighbour(i, [&](Index j, double distance_m) {
    if (are_of_two_faces(own, samples[j])) others.push_back({&samples[j], distance_m});
  });
  if (others.empty()) return;
  std::ranges::sort(others, {}, &Other::distance_m);
  const BentSample& first = *others.front().sample;
  const auto is_in = [&](const Vector3d& x) {  // No face cuts it off, as a third one may near a corner.
    return std::ranges::all_of(others,
                               [&](const Other& other) { return height(*other.sample, x).over_m < 1e-3 * spacing_m; });
  };
  const Vector3d edge = meeting(own, first, nullptr, 0.5 * (own.p_m + first.p_m));
  if ((edge - own.p_m).norm() < 1.5 * spacing_m && is_in(edge))
    found.edges.push_back({edge, own.n.cross(first.n).normalized()});
  const auto third = std::ranges::find_if(others, [&](const Other& other) {
    return other.sample->n.dot(first.n) < kUnlike && std::abs(own.n.dot(first.n.cross(other.sample->n))) > 0.2;
  });
  if (third == others.end()) return;
  const Vector3d corner = meeting(own, first, third->sample, edge);
  if ((corner - own.p_m).norm() < kBeside * spacing_m && is_in(corner)) found.corners.push_back({corner});
}

/// Returns those that are no nearer than `apart_m` to one kept before.
void keep_apart(const std::vector<SharpPoint>& more, double apart_m, std::vector<SharpPoint>& kept) {
  for (const SharpPoint& point : more) {
    const auto is_near = [&](const SharpPoint& other) {
      return (other.p_m - point.p_m).squaredNorm() < apart_m * apart_m;
    };
    if (std::ranges::none_of(kept, is_near)) kept.push_back(point);
  }
}

/// Returns samples at the rim of a flat face without an edge there: of a plate thinner than its samples' spacing.
std::vector<SharpPoint> rims(const std::vector<BentSample>& samples, const PointGrid& grid, double spacing_m,
                             const std::vector<SharpPoint>& sharp) {
  constexpr double kAside =
      0.35;  // Of their mean way neighbours on half a disk are to one side by 0.64, all around by 0.
  std::vector<SharpPoint> found;
  for (Index i = 0; i < std::ssize(samples); ++i) {
    const BentSample& own = samples[i];
    if (own.k1_per_m != 0.0 || own.k2_per_m != 0.0) continue;
    Vector3d aside_m = Vector3d::Zero();
    double ways_m = 0.0;
    grid.for_each_neighbour(i, [&](Index j, double distance_m) {
      if (samples[j].n.dot(own.n) < kUnlike) return;
      aside_m += samples[j].p_m - own.p_m;
      ways_m += distance_m;
    });
    const auto is_near = [&](const SharpPoint& point) { return (point.p_m - own.p_m).norm() < kBends * spacing_m; };
    if (aside_m.norm() >= kAside * ways_m && std::ranges::none_of(sharp, is_near)) found.push_back({own.p_m});
  }
  return found;
}

/// Orders points so that each is as far as possible from all before it.
void spread_out(std::vector<SharpPoint>& points) {
  std::vector<double> squared_m2(points.size(), std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    for (std::size_t i = k + 1; i < points.size(); ++i)
      squared_m2[i] = std::min(squared_m2[i], (points[i].p_m - points[k].p_m).squaredNorm());
    const auto next = std::max_element(squared_m2.begin() + k + 1, squared_m2.end()) - squared_m2.begin();
    std::swap(points[k + 1], points[next]);
    std::swap(squared_m2[k + 1], squared_m2[next]);
  }
}

/// The deviation of point i from the chords between its neighbours along its edge, on both sides of it.
struct Chords {
  double least_m = std::numeric_limits<double>::infinity();  ///< Distance of the nearest one; infinite: none.
  double shortest_m = std::numeric_limits<double>::infinity(),
         off_m = 0.0;  ///< The shortest: its length, how far it is.
};

Chords chords(const std::vector<SharpPoint>& points, std::size_t i, double reach_m) {
  std::vector<Vector3d> around;
  for (const SharpPoint& other : points) {
    const Vector3d way_m = other.p_m - points[i].p_m;
    const double distance_m = way_m.norm();
    const bool is_along = std::abs(way_m.dot(points[i].along)) > 0.8 * distance_m;  // Not of another edge beside it.
    if (distance_m > 0.0 && distance_m < reach_m && is_along) around.push_back(way_m);
  }
  Chords found;
  for (const Vector3d& a : around) {
    for (const Vector3d& b : around) {
      if (a.dot(b) >= 0.0) continue;
      const double length_m = (b - a).norm(), off_m = a.cross(b).norm() / length_m;
      found.least_m = std::min(found.least_m, off_m);
      if (length_m >= found.shortest_m) continue;
      found.shortest_m = length_m;
      found.off_m = off_m;
    }
  }
  return found;
}

std::vector<Vector3d> places_of(const std::vector<BentSample>& samples) {
  std::vector<Vector3d> places_m;
  for (const BentSample& sample : samples) places_m.push_back(sample.p_m);
  return places_m;
}

/// Estimates the error of the surface around a sample at its neighbours, where their cells meet: half way.
double missed_m(const std::vector<BentSample>& samples, const PointGrid& grid, Index i, double spacing_m) {
  constexpr double kHalfWay = 0.125;  // Of the third-order term.
  double most_m = 0.0;
  grid.for_each_neighbour(i, [&](Index j, double distance_m) {
    if (distance_m >= 1.5 * spacing_m || samples[i].n.dot(samples[j].n) < kUnlike) return;
    most_m = std::max(most_m, kHalfWay * std::abs(height(samples[i], samples[j].p_m).over_m));
  });
  return most_m;
}

}  // namespace

PointBalls::PointBalls(const std::vector<Vector3d>& points_m) : points_(points_m.size()) {
  const auto around = [](const auto& centres, std::size_t first, std::size_t last, const auto& radius) {
    Ball ball{Vector3d::Zero(), 0.0};
    for (std::size_t i = first; i < last; ++i) ball.middle_m += centres(i) / static_cast<double>(last - first);
    for (std::size_t i = first; i < last; ++i)
      ball.radius_m = std::max(ball.radius_m, (centres(i) - ball.middle_m).norm() + radius(i));
    return ball;
  };
  for (std::size_t i = 0; i < points_m.size(); i += kBall) {
    balls_.push_back(around([&](std::size_t k) { return points_m[k]; }, i, std::min(points_m.size(), i + kBall),
                            [](std::size_t) { return 0.0; }));
  }
  for (std::size_t i = 0; i < balls_.size(); i += kBall) {
    groups_.push_back(around([&](std::size_t k) { return balls_[k].middle_m; }, i, std::min(balls_.size(), i + kBall),
                             [&](std::size_t k) { return balls_[k].radius_m; }));
  }
}

SampledSolid::SampledSolid(const PointCloud& cloud)
    : surface_(cloud),
      spacing_m_(sample_spacing_m(surface_.cloud())),
      reach_m_(surface_.cloud().points_m.colwise().norm().maxCoeff()),
      flat_per_m_(kBent_m / (reach_m_ * reach_m_)),
      bent_balls_({}),
      flat_balls_({}) {
  const PointCloud& samples = surface_.cloud();
  const PointGrid grid(samples.points_m, kBeside * spacing_m_);
  std::vector<BentSample> all;
  for (Index i = 0; i < samples.points_m.cols(); ++i) {
    all.push_back({samples.points_m.col(i), samples.normals.col(i), Vector3d::Zero()});
    bend(samples, grid, i, spacing_m_, flat_per_m_, all.back());
  }
  SharpPlaces sharp;
  for (Index i = 0; i < std::ssize(all); ++i) {
    find_sharp(all, grid, i, spacing_m_, sharp);
    const BentSample& sample = all[i];
    (sample.k1_per_m != 0.0 || sample.k2_per_m != 0.0 ? bent_ : flat_).push_back(sample);
    most_bent_per_m_ = std::max(most_bent_per_m_, sample.k1_per_m);
    round_error_m_ = std::max(round_error_m_, missed_m(all, grid, i, spacing_m_));
  }
  bent_balls_ = PointBalls(places_of(bent_));
  flat_balls_ = PointBalls(places_of(flat_));

  keep_apart(sharp.corners, kApart * spacing_m_, sharp_);
  keep_apart(sharp.edges, kApart * spacing_m_, sharp_);
  keep_apart(rims(all, grid, spacing_m_, sharp_), kApart * spacing_m_, sharp_);
  spread_out(sharp_);
  for (std::size_t i = 0; i < sharp_.size(); ++i) {
    const Chords near = chords(sharp_, i, kEdgeTells * spacing_m_);
    sharp_[i].is_straight = near.least_m < kBent_m;
    reach_m_ = std::max(reach_m_, sharp_[i].p_m.norm());
    // An edge that turns by more than some 45 degrees has a corner here. Between two points a polygon is off by a
    // quarter of what a point is off the chord of its neighbours.
    if (near.off_m < 0.2 * near.shortest_m) edge_error_m_ = std::max(edge_error_m_, 0.25 * near.off_m);
  }
  std::stable_partition(sharp_.begin(), sharp_.end(), [](const SharpPoint& point) { return !point.is_straight; });
}

}  // namespace thenar
