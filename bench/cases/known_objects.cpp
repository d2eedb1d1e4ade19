// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/known_objects.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "bench/cases/random.h"
#include "collision/point_tree.h"
#include "collision/shapes.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

constexpr double kPulpRadius_m = 8e-3;
constexpr double kSide_m = 50e-3;

double box_distance_m(const Vector3d& p_m) {
  const Vector3d beyond = p_m.cwiseAbs().array() - 0.5 * kSide_m;
  return beyond.cwiseMax(0.0).norm() + std::min(0.0, beyond.maxCoeff());
}

/// g(p) < 0 inside: an ellipsoid with waves of 30 mm, some 1.2 mm high. Their radii of curvature exceed 8 mm, so that
/// the nearest point is unique within the depths of a grasp.
struct BumpyEllipsoid {
  static constexpr double kWave_per_m = 2.0 * std::numbers::pi / 30e-3, kHeight = 0.1;
  const Vector3d semi_axes_m{20e-3, 25e-3, 35e-3};

  struct Level {
    double value;
    Vector3d gradient;
  };
  [[nodiscard]] Level level(const Vector3d& p_m) const {
    const Eigen::Array3d s = (kWave_per_m * p_m).array().sin(), c = (kWave_per_m * p_m).array().cos();
    const Vector3d waves(c.x() * s.y() * s.z(), s.x() * c.y() * s.z(), s.x() * s.y() * c.z());
    return {p_m.cwiseQuotient(semi_axes_m).squaredNorm() - 1.0 + kHeight * s.prod(),
            2.0 * p_m.cwiseQuotient(semi_axes_m.cwiseAbs2()) + kHeight * kWave_per_m * waves};
  }
  [[nodiscard]] Vector3d on_ray(const Vector3d& direction) const {
    double near = 0.5 * semi_axes_m.minCoeff(), far = 2.0 * semi_axes_m.maxCoeff();
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (near + far);
      (level(middle * direction).value < 0.0 ? near : far) = middle;
    }
    return near * direction;
  }
  /// By steps along the surface towards p and onto it. A step along it is off by the curvature times the distance,
  /// hence the damping.
  [[nodiscard]] double distance_m(const Vector3d& p_m) const {
    constexpr double kDamping = 0.7, kEnough_m = 1e-12;
    Vector3d s = p_m;
    for (int i = 0; i < 100; ++i) {
      const Level at = level(s);
      const Vector3d n = at.gradient.normalized();
      const Vector3d along = kDamping * ((p_m - s) - (p_m - s).dot(n) * n);
      const Vector3d onto = -at.value / at.gradient.norm() * n;
      s += along + onto;
      if (along.squaredNorm() + onto.squaredNorm() < kEnough_m * kEnough_m) break;
    }
    return std::copysign((p_m - s).norm(), level(p_m).value);
  }
};

/// A pulp whose surface touches the object's sample i from outside, turned at random about everything.
Isometry3d touching(const PointCloud& cloud, Index i, Random& random) {
  Isometry3d X = Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(random.uniform(0.0, std::numbers::pi), random.direction()).toRotationMatrix();
  X.translation() = cloud.points_m.col(i) + kPulpRadius_m * cloud.normals.col(i);
  return X;
}

}  // namespace

TriangleMesh geodesic_sphere(Index n) {
  const double phi = std::numbers::phi;
  const std::array<Vector3d, 12> v{Vector3d{-1, phi, 0}, {1, phi, 0}, {-1, -phi, 0}, {1, -phi, 0},
                                   {0, -1, phi},         {0, 1, phi}, {0, -1, -phi}, {0, 1, -phi},
                                   {phi, 0, -1},         {phi, 0, 1}, {-phi, 0, -1}, {-phi, 0, 1}};
  constexpr std::array<std::array<int, 3>, 20> kFaces{{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                                       {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                                       {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                                       {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};
  std::vector<Vector3d> corners;
  std::vector<Vector3i> triangles;
  std::map<std::array<long, 3>, int> numbers;  // Faces share the corners on their edges.
  const auto corner = [&](const Vector3d& p) {
    const std::array<long, 3> key{std::lround(1e7 * p.x()), std::lround(1e7 * p.y()), std::lround(1e7 * p.z())};
    const auto [at, is_new] = numbers.try_emplace(key, static_cast<int>(corners.size()));
    if (is_new) corners.push_back(p.normalized());
    return at->second;
  };
  for (const auto& [a, b, c] : kFaces) {
    const auto at = [&, a = a, b = b, c = c](Index i, Index j) {
      return corner(
          (static_cast<double>(n - i - j) * v[a] + static_cast<double>(i) * v[b] + static_cast<double>(j) * v[c]) /
          static_cast<double>(n));
    };
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; i + j < n; ++j) {
        triangles.emplace_back(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < n) triangles.emplace_back(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
    }
  }
  TriangleMesh mesh{Matrix3Xd(3, std::ssize(corners)), Eigen::Matrix3Xi(3, std::ssize(triangles))};
  for (Index i = 0; i < mesh.vertices_m.cols(); ++i) mesh.vertices_m.col(i) = corners[i];
  for (Index i = 0; i < mesh.triangles.cols(); ++i) mesh.triangles.col(i) = triangles[i];
  if (mesh.vertices_m.cols() != 10 * n * n + 2) throw std::logic_error("geodesic_sphere: corners do not meet");
  return mesh;
}

KnownObject known_box(Index n) {
  const double cell_m = kSide_m / static_cast<double>(n), half_m = 0.5 * kSide_m;
  KnownObject box{
      "box", {Matrix3Xd(3, 6 * n * n), Matrix3Xd::Zero(3, 6 * n * n)}, {}, box_distance_m, Vector3d::Constant(kSide_m)};
  box.mesh = {Matrix3Xd(3, 6 * (n + 1) * (n + 1)), Eigen::Matrix3Xi(3, 12 * n * n)};
  Random random(1);
  Index sample = 0, corner = 0, triangle = 0;
  for (int face = 0; face < 6; ++face) {
    // u, v and the outward normal are right-handed.
    const int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    const double side = face % 2 == 0 ? 1.0 : -1.0;
    const auto place = [&](auto column, double at_u, double at_v) {
      column[axis] = side * half_m;
      column[u] = side * (at_u * cell_m - half_m);
      column[v] = at_v * cell_m - half_m;
    };
    const Index first = corner;
    for (Index i = 0; i <= n; ++i) {
      for (Index j = 0; j <= n; ++j) {
        const auto at_u = static_cast<double>(i), at_v = static_cast<double>(j);
        place(box.mesh.vertices_m.col(corner++), at_u, at_v);
        if (i == n || j == n) continue;
        place(box.cloud.points_m.col(sample), at_u + random.uniform(0.2, 0.8), at_v + random.uniform(0.2, 0.8));
        box.cloud.normals(axis, sample++) = side;
        const auto k = static_cast<int>(first + i * (n + 1) + j), row = static_cast<int>(n + 1);
        box.mesh.triangles.col(triangle++) << k, k + row, k + 1;
        box.mesh.triangles.col(triangle++) << k + row, k + row + 1, k + 1;
      }
    }
  }
  return box;
}

KnownObject known_scan(Index n) {
  const BumpyEllipsoid exact;
  KnownObject scan{"scan", {}, geodesic_sphere(n), [exact](const Vector3d& p) { return exact.distance_m(p); }, {}};
  Matrix3Xd& corners = scan.mesh.vertices_m;
  scan.cloud.normals.resize(3, corners.cols());
  const double spacing = 1.1 / static_cast<double>(n);  // on the unit sphere
  Random random(1);
  for (Index i = 0; i < corners.cols(); ++i) {
    const Vector3d direction = (corners.col(i) + 0.3 * spacing * random.uniform(0.0, 1.0) * random.direction());
    corners.col(i) = exact.on_ray(direction.normalized());
    scan.cloud.normals.col(i) = exact.level(corners.col(i)).gradient.normalized();
  }
  scan.cloud.points_m = corners;
  return scan;
}

KnownObject known_ball(Index n) {
  constexpr double kRadius_m = 20e-3;
  KnownObject ball{"ball", {}, geodesic_sphere(n), [](const Vector3d& p) { return p.norm() - kRadius_m; }, {}};
  ball.cloud.normals = ball.mesh.vertices_m;
  ball.mesh.vertices_m *= kRadius_m;
  ball.cloud.points_m = ball.mesh.vertices_m;
  return ball;
}

Matrix3Xd pulp_control_points(Index leaves) {
  // 7.5 samples a leaf, as the reference scene has.
  const Matrix3Xd points_m = sample_sphere(kPulpRadius_m, 15 * leaves / 2).points_m;
  const std::vector<Index> order = order_by_leaves(points_m, leaves);
  const std::vector<TreeNode> nodes = tree_nodes(points_m.cols(), leaves, 1);
  Matrix3Xd controls_m(3, leaves);
  for (Index i = 0; i < leaves; ++i) {
    Vector3d sum = Vector3d::Zero();
    for (Index k = nodes[i].begin; k < nodes[i].end; ++k) sum += points_m.col(order[k]);
    controls_m.col(i) = kPulpRadius_m * sum.normalized();
  }
  return controls_m;
}

std::vector<Grip> random_grips(const KnownObject& object, const Matrix3Xd& controls_m, const GripTask& task, int count,
                               std::uint64_t seed) {
  Random random(seed);
  std::vector<Grip> grips(count);
  std::vector<double> gaps(controls_m.cols());
  const auto natural = std::min<Index>(task.per_finger * 13 / 10, controls_m.cols() - 1);
  for (Grip& grip : grips) {
    for (Isometry3d& X : grip) {
      const Index i = random.whole(Index{0}, object.cloud.points_m.cols() - 1);
      X = touching(object.cloud, i, random);
      for (Index k = 0; k < controls_m.cols(); ++k) gaps[k] = object.distance_m(X * controls_m.col(k));
      std::nth_element(gaps.begin(), gaps.begin() + natural, gaps.end());
      const double depth_m = std::clamp(gaps[natural] - task.band_m, -task.band_m, 0.5 * kPulpRadius_m);
      X.translation() -= depth_m * object.cloud.normals.col(i);
    }
  }
  return grips;
}

std::vector<Grip> creeping_grip(const Grip& start, int count, std::uint64_t seed) {
  constexpr double kStep_m = 5e-6, kTurn_rad = 0.5e-3;
  Random random(seed);
  std::vector<Grip> grips{start};
  for (int i = 1; i < count; ++i) {
    grips.push_back(grips.back());
    for (std::size_t k = 0; k < start.size(); ++k) {
      Isometry3d& X = grips.back()[k];
      // Drawn back a little, so that the grip neither opens nor sinks in.
      const Vector3d back = 0.02 * (start[k].translation() - X.translation());
      X.translation() += back + kStep_m * random.direction();
      X.rotate(Eigen::AngleAxisd(kTurn_rad * random.normal(), random.direction()));
    }
  }
  for (int i = count - 2; i > 0; --i) grips.push_back(grips[i]);
  return grips;
}

}  // namespace thenar
