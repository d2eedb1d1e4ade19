// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "collision/implicit_surface.h"
#include "collision/shapes.h"

/// How far distances to a sampled surface are off, over many queries.
namespace thenar::distance_errors {

using Eigen::Index;
using Eigen::Vector3d;

inline constexpr double kMm = 1e-3;
inline constexpr double kReach_m = 4e-3;
inline constexpr int kQueries = 5000;
inline const Vector3d kBox_m(50e-3, 50e-3, 100e-3);
inline const Vector3d kHalf_m = 0.5 * kBox_m;

inline const PointCloud& box_cloud() {
  static const PointCloud kCloud = sample_box(kBox_m, 36000);
  return kCloud;
}

inline double box_distance_m(const Vector3d& p_m, const Vector3d& half_m) {
  const Vector3d beyond = p_m.cwiseAbs() - half_m;
  return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
}

class Random {
 public:
  explicit Random(unsigned seed) : bits_(seed) {}
  double between(double low, double high) { return low + (high - low) * static_cast<double>(bits_()) / 0x1p32; }
  double sign() { return between(-1.0, 1.0) < 0.0 ? -1.0 : 1.0; }
  Vector3d in_cube(double half) { return {between(-half, half), between(-half, half), between(-half, half)}; }
  Vector3d direction() {
    for (;;) {
      const Vector3d v = in_cube(1.0);
      if (v.norm() < 1.0 && v.norm() > 0.1) return v.normalized();
    }
  }
  /// Standard normal in each coordinate [Box & Muller 1958].
  Vector3d gaussian() {
    const auto one = [&] {
      return std::sqrt(-2.0 * std::log(1.0 - between(0.0, 1.0))) * std::cos(2.0 * std::numbers::pi * between(0.0, 1.0));
    };
    return {one(), one(), one()};
  }

 private:
  std::mt19937 bits_;
};

/// Errors over many queries.
struct Errors {
  int undefined = 0;   ///< No distance.
  int wrong_sign = 0;  ///< Where the true distance is above 0.05 mm.
  double bias_mm = 0.0, mean_mm = 0.0, max_mm = 0.0;
};

using Query = std::function<Vector3d(Random&)>;
using Truth = std::function<double(const Vector3d&)>;

inline Errors measure(const ImplicitSurface& surface, const Query& query, const Truth& truth_m,
                      double reach_m = kReach_m) {
  Random random(1);
  Errors errors;
  for (int i = 0; i < kQueries; ++i) {
    const Vector3d x_m = query(random);
    const std::optional<SurfaceDistance> to = surface.distance(x_m, reach_m);
    if (!to) {
      ++errors.undefined;
      continue;
    }
    const double error_mm = (to->distance_m - truth_m(x_m)) / kMm;
    errors.bias_mm += error_mm;
    errors.mean_mm += std::abs(error_mm);
    errors.max_mm = std::max(errors.max_mm, std::abs(error_mm));
    if (std::abs(truth_m(x_m)) > 0.05 * kMm && to->distance_m * truth_m(x_m) < 0.0) ++errors.wrong_sign;
  }
  errors.bias_mm /= kQueries - errors.undefined;
  errors.mean_mm /= kQueries - errors.undefined;
  return errors;
}

inline Errors measure(const ImplicitSurface& surface, const Query& query, double reach_m = kReach_m) {
  const Truth truth_m = [](const Vector3d& x_m) { return box_distance_m(x_m, kHalf_m); };
  return measure(surface, query, truth_m, reach_m);
}

/// Points at a given distance from the middle of the face y+.
inline Query over_face(double gap_mm) {
  return [=](Random& random) -> Vector3d {
    return {random.between(-20, 20) * kMm, kHalf_m.y() + gap_mm * kMm, random.between(-40, 40) * kMm};
  };
}

/// Points on a ring around one of the four edges along z.
inline Query around_edge(double radius_mm) {
  return [=](Random& random) -> Vector3d {
    const double angle = random.between(0.0, 2.0 * std::numbers::pi);
    return {random.sign() * (kHalf_m.x() + radius_mm * kMm * std::cos(angle)),
            random.sign() * (kHalf_m.y() + radius_mm * kMm * std::sin(angle)), random.between(-40, 40) * kMm};
  };
}

/// Points on a sphere around one of the eight corners.
inline Query around_corner(double radius_mm) {
  return [=](Random& random) -> Vector3d {
    const Vector3d signs(random.sign(), random.sign(), random.sign());
    return kHalf_m.cwiseProduct(signs) + radius_mm * kMm * random.direction();
  };
}

inline PointCloud subset(const PointCloud& cloud, const std::function<bool(Index)>& keep) {
  std::vector<Index> kept;
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    if (keep(i)) kept.push_back(i);
  }
  return {cloud.points_m(Eigen::all, kept), cloud.normals(Eigen::all, kept)};
}

}  // namespace thenar::distance_errors
