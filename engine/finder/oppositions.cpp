// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/oppositions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "collision/blue_noise.h"
#include "collision/point_cloud.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

constexpr double kWhole = 0.7;  // A patch with less is at an edge.

struct Place {
  Vector3d point, normal;
  double patch;
};

/// Returns the cloud's samples in random order, without those nearer than `spacing_m` to one before.
std::vector<Index> spread(const PointCloud& cloud, int count, std::uint32_t seed) {
  const Index samples = cloud.points_m.cols();
  std::vector<Index> order(samples);
  std::iota(order.begin(), order.end(), Index{0});
  Uniform uniform(seed);
  for (Index i = samples - 1; i > 0; --i) {
    std::swap(order[i], order[static_cast<Index>(uniform() * static_cast<double>(i + 1))]);
  }
  // Discs of this distance would cover the surface on a square lattice; in random order fewer fit.
  const double area_m2 = static_cast<double>(samples) * std::pow(sample_spacing_m(cloud), 2);
  const double spacing_m = 0.8 * std::sqrt(area_m2 / count);
  std::vector<Index> chosen;
  Eigen::Matrix3Xd points_m(3, std::min<Index>(samples, 4 * count));
  for (const Index i : order) {
    const Index n = std::ssize(chosen);
    if (n == points_m.cols()) break;
    const Vector3d p = cloud.points_m.col(i);
    const auto is_other_side = [&](Index j) { return cloud.normals.col(chosen[j]).dot(cloud.normals.col(i)) < 0.5; };
    bool crowded = false;
    for (Index j = 0; j < n && !crowded; ++j) {
      crowded = (points_m.col(j) - p).squaredNorm() < spacing_m * spacing_m && !is_other_side(j);
    }
    if (crowded) continue;
    points_m.col(n) = p;
    chosen.push_back(i);
  }
  return chosen;
}

bool alike(const Opposition& a, const Opposition& b, double near_m) {
  return (a.from_O - b.from_O).squaredNorm() + (a.to_O - b.to_O).squaredNorm() < near_m * near_m;
}

std::vector<Place> places_of(const ImplicitSurface& object, const PatchMeter& patches,
                             const OppositionSettings& settings) {
  constexpr double kPierced_m = 0.5e-3;
  const PointCloud& cloud = object.cloud();
  std::vector<Place> places;
  for (const Index i : spread(cloud, settings.places, settings.seed)) {
    const double share = patches.share_at(i);
    if (share < kWhole) continue;
    const Place place{cloud.points_m.col(i), patches.mean_normal(i), share};
    // A pulp must fit there: in a hollow narrower than it another part of the surface is nearer.
    const auto at =
        object.distance(place.point + settings.reach_m * place.normal, std::numeric_limits<double>::infinity());
    if (at && at->distance_m > settings.reach_m - kPierced_m - 0.1 * settings.reach_m) places.push_back(place);
  }
  return places;
}

}  // namespace

PatchMeter::PatchMeter(const ImplicitSurface& object, double radius_m)
    : object_(object),
      // Enough samples to count.
      radius_m_(std::max(radius_m, 1.8 * sample_spacing_m(object.cloud()))),
      sample_area_m2_(std::pow(sample_spacing_m(object.cloud()), 2)),
      grid_(object.cloud().points_m, radius_m_) {}

double PatchMeter::share(const Vector3d& x_O) const {
  return share_at(object_.nearest(x_O, std::numeric_limits<double>::infinity()).sample);
}

double PatchMeter::share_at(Index sample) const {
  const PointCloud& cloud = object_.cloud();
  const Vector3d n = cloud.normals.col(sample);
  double same = 1.0;
  grid_.for_each_neighbour(sample, [&](Index j, double) {
    if (cloud.normals.col(j).dot(n) > 0.5) same += 1.0;
  });
  return std::min(1.0, same * sample_area_m2_ / (std::numbers::pi * radius_m_ * radius_m_));
}

Vector3d PatchMeter::mean_normal(Index sample) const {
  const PointCloud& cloud = object_.cloud();
  const Vector3d n = cloud.normals.col(sample);
  Vector3d sum = n;
  grid_.for_each_neighbour(sample, [&](Index j, double) {
    if (cloud.normals.col(j).dot(n) > 0.5) sum += cloud.normals.col(j);
  });
  return sum.normalized();
}

Oppositions find_oppositions(const ImplicitSurface& object, const PatchMeter& patches,
                             const OppositionSettings& settings) {
  const std::vector<Place> places = places_of(object, patches, settings);
  Oppositions found{.pairs = {}, .places = static_cast<int>(places.size())};
  const double size_m = object.bounds().diagonal().norm();
  found.least_width_m = std::numeric_limits<double>::infinity();
  std::vector<Opposition> all;
  for (const Place& from : places) {
    for (const Place& to : places) {
      const Vector3d v = to.point - from.point;
      const double width_m = v.norm();
      if (!(width_m > 0.0)) continue;
      const Vector3d u = v / width_m;
      const double cosine = std::min(-from.normal.dot(u), to.normal.dot(u));
      const double angle_rad = std::acos(std::clamp(cosine, -1.0, 1.0));
      found.least_angle_rad = std::min(found.least_angle_rad, angle_rad);
      if (angle_rad > settings.cone_rad) continue;
      found.least_width_m = std::min(found.least_width_m, width_m);
      if (width_m < settings.least_m || width_m > settings.most_m) continue;
      found.fits = true;
      const GraspWish& wish = settings.wish;
      const Vector3d middle_O = 0.5 * (from.point + to.point);
      if (wish.axis_O && std::abs(u.dot(*wish.axis_O)) < std::cos(0.3)) continue;
      if (wish.at_O && (middle_O - *wish.at_O).norm() > std::max(8e-3, 0.15 * size_m)) continue;
      const Vector3d c = settings.centre_of_mass_m - from.point;
      const double off_m = (c - u * std::clamp(u.dot(c), 0.0, width_m)).norm();
      const double cost = angle_rad / settings.cone_rad + 1.5 * off_m / size_m + (2.0 - from.patch - to.patch) +
                          0.5 * std::max(0.0, width_m / settings.most_m - 0.7);
      all.push_back({from.point, to.point, width_m, angle_rad, cost});
    }
  }
  if (!std::isfinite(found.least_width_m)) found.least_width_m = 0.0;
  std::sort(all.begin(), all.end(), [](const Opposition& a, const Opposition& b) { return a.cost < b.cost; });
  // All over the object, not only where it is best.
  for (double near_m = 0.25 * size_m; std::ssize(found.pairs) < settings.pairs && near_m > 0.02 * size_m;
       near_m *= 0.6) {
    for (const Opposition& pair : all) {
      if (std::ssize(found.pairs) == settings.pairs) break;
      if (std::none_of(found.pairs.begin(), found.pairs.end(), [&](const auto& p) { return alike(p, pair, near_m); })) {
        found.pairs.push_back(pair);
      }
    }
  }
  std::sort(found.pairs.begin(), found.pairs.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  return found;
}

}  // namespace thenar
