// SPDX-License-Identifier: Apache-2.0
#include "engine/insertion/peg_theory.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace thenar {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// A possible contact of the peg in the plane (x, z).
struct PegPlace {
  double gap_m = 1.0;
  bool is_there = false;  ///< The two are beside one another. The gap goes on beyond.
  Vector2d p_m = Vector2d::Zero();
  Vector2d n = Vector2d::Zero(), up = Vector2d::Zero();  ///< Into the peg; along the surface, against the way in.
};
constexpr int kPlaces = 6;  // Right and left: the peg's end on the chamfer, on the wall; the mouth on the peg.
bool is_chamfer(int which) { return which < 2; }

PegPlace peg_place(const PegShape& shape, const Vector3d& pose, int which) {
  const double side = which % 2 == 0 ? 1.0 : -1.0;
  const Vector2d end = pose.head<2>(), along(std::sin(pose[2]), std::cos(pose[2])), across(along[1], -along[0]);
  const Vector2d corner = end + side * shape.radius_m * across;
  const double beyond_m = side * corner[0] - shape.hole_radius_m, above_m = corner[1] + shape.chamfer_m;
  constexpr double kRounding_m = 1e-9;
  if (is_chamfer(which)) {
    const double s = std::sqrt(0.5);
    const bool is_there = above_m > -kRounding_m && corner[1] < kRounding_m && shape.chamfer_m > 0.0;
    return {s * (above_m - beyond_m), is_there, corner, {-side * s, s}, {side * s, s}};
  }
  if (which < 4) return {-beyond_m, above_m < kRounding_m, corner, {-side, 0.0}, {0.0, 1.0}};
  const Vector2d mouth(side * shape.hole_radius_m, -shape.chamfer_m);
  return {side * (mouth - end).dot(across) - shape.radius_m, (mouth - end).dot(along) > -kRounding_m, mouth,
          -side * across, along};
}

/// The equilibrium of the springs and so many sliding points.
struct PegBalance {
  const PegShape& shape;
  const PegSpring& spring;
  PegPose wanted;

  /// Returns the spring's force and moment about the middle of the peg's end.
  [[nodiscard]] Vector3d pull(const Vector3d& pose) const {
    const double h = spring.above_end_m;
    const Vector2d lever = h * Vector2d(std::sin(pose[2]), std::cos(pose[2]));
    const Vector2d at(wanted.x_m + h * std::sin(wanted.tilt_rad), wanted.z_m + h * std::cos(wanted.tilt_rad));
    const Vector2d f = spring.translation_N_per_m * (at - pose.head<2>() - lever);
    const double m = spring.rotation_Nm_per_rad * (wanted.tilt_rad - pose[2]);
    return {f[0], f[1], m + lever[1] * f[0] - lever[0] * f[1]};
  }
  /// Returns the residual of z = (pose, then a normal force per place).
  [[nodiscard]] VectorXd residual(const std::vector<int>& places, const VectorXd& z) const {
    const Vector3d pose = z.head<3>();
    VectorXd r(z.size());
    r.head<3>() = pull(pose);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const PegPlace at = peg_place(shape, pose, places[i]);
      const Vector2d f = z[3 + static_cast<Eigen::Index>(i)] * (at.n + shape.friction * at.up),
                     lever = at.p_m - pose.head<2>();
      r.head<3>() += Vector3d(f[0], f[1], lever[1] * f[0] - lever[0] * f[1]);
      r[3 + static_cast<Eigen::Index>(i)] = at.gap_m;
    }
    return r;
  }
  /// Solves by Newton's method; nothing if it does not converge.
  [[nodiscard]] std::optional<VectorXd> solve(const std::vector<int>& places, VectorXd z) const {
    for (int k = 0; k < 30; ++k) {
      const VectorXd r = residual(places, z);
      if (!r.allFinite()) return std::nullopt;
      if (r.head<3>().norm() < 1e-10 && r.tail(r.size() - 3).norm() < 1e-13) return z;
      constexpr double kStep = 1e-7;  // Step for metres, radians and newtons: they enter nearly linearly.
      Eigen::MatrixXd slopes(z.size(), z.size());
      for (Eigen::Index j = 0; j < z.size(); ++j) {
        const VectorXd by = kStep * VectorXd::Unit(z.size(), j);
        slopes.col(j) = (residual(places, z + by) - residual(places, z - by)) / (2.0 * kStep);
      }
      z -= slopes.fullPivLu().solve(r);
    }
    return std::nullopt;
  }
};

/// Tests whether these places touch there, push, and no other penetrates the peg.
bool is_right(const PegShape& shape, const std::vector<int>& places, const VectorXd& z) {
  const Vector3d pose = z.head<3>();
  for (int which = 0; which < kPlaces; ++which) {
    const PegPlace at = peg_place(shape, pose, which);
    const auto found = std::ranges::find(places, which);
    if (found == places.end() ? at.is_there && at.gap_m < -1e-12
                              : !at.is_there || z[3 + (found - places.begin())] < 0.0)
      return false;
  }
  return true;
}

/// Steps from pose and places to the next: with the same places, or else with those, two at most, of the least
/// displacement of the peg.
bool find_balance(const PegBalance& balance, Vector3d& pose, std::vector<int>& places) {
  const Vector3d before = pose;
  const auto try_places = [&](const std::vector<int>& tried) -> std::optional<Vector3d> {
    VectorXd z = VectorXd::Zero(3 + std::ssize(tried));
    z.head<3>() = before;
    const auto found = balance.solve(tried, z);
    if (!found || !is_right(balance.shape, tried, *found)) return std::nullopt;
    return Vector3d(found->head<3>());
  };
  if (const auto found = try_places(places)) {
    pose = *found;
    return true;
  }
  double least_m = std::numeric_limits<double>::infinity();
  const auto attempt = [&](const std::vector<int>& tried) {
    const auto found = try_places(tried);
    const double way_m = found ? (*found - before).head<2>().norm() : least_m;
    if (!(way_m < least_m)) return;
    least_m = way_m;
    pose = *found;
    places = tried;
  };
  attempt({});
  for (int i = 0; i < kPlaces; ++i) {
    attempt({i});
    for (int j = 0; j < i; ++j) attempt({j, i});
  }
  return std::isfinite(least_m);
}

}  // namespace

std::vector<PegForce> peg_theory(const PegShape& shape, const PegSpring& spring, const std::vector<PegPose>& wanted) {
  std::vector<PegForce> forces;
  std::vector<int> places;
  if (wanted.empty()) return forces;
  Vector3d pose(wanted.front().x_m, wanted.front().z_m, wanted.front().tilt_rad);
  for (const PegPose& target : wanted) {
    const PegBalance balance{shape, spring, target};
    const double z_m = pose[1];
    if (!find_balance(balance, pose, places) || pose[1] > z_m + 1e-9) break;
    const Vector3d pull = balance.pull(pose);
    PegForce force{-pose[1], -pull[1], pull[0], pull[2], pose[2], static_cast<int>(places.size())};
    force.on_chamfer = std::ranges::any_of(places, is_chamfer);
    forces.push_back(force);
  }
  return forces;
}

}  // namespace thenar
