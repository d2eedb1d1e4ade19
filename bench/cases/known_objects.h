// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "collision/point_cloud.h"
#include "collision/triangles.h"

namespace thenar {

/// An icosahedron whose edges are cut into n parts, pushed out to the unit sphere: 10 n^2 + 2 corners.
[[nodiscard]] TriangleMesh geodesic_sphere(Eigen::Index n);

/// An object known twice over: as the samples that a scan of it would give, and exactly. Centred on the origin.
struct KnownObject {
  std::string name;
  PointCloud cloud;
  TriangleMesh mesh;                                         ///< As fine as the cloud: what a method for meshes gets.
  std::function<double(const Eigen::Vector3d&)> distance_m;  ///< Exact and signed, to well below a nanometre.
  std::optional<Eigen::Vector3d> box_m;                      ///< Its size, if it is a box.
};

/// The reference scene's cube of 50 mm: 6 n^2 samples, one in each cell of a grid on its faces, jittered.
[[nodiscard]] KnownObject known_box(Eigen::Index per_side);

/// A smooth bumpy ellipsoid of 40 x 50 x 70 mm with 10 n^2 + 2 samples, as unevenly spaced as a scan's: 61 gives
/// 37 212.
[[nodiscard]] KnownObject known_scan(Eigen::Index frequency);

/// A ball of radius 20 mm with 10 n^2 + 2 samples.
[[nodiscard]] KnownObject known_ball(Eigen::Index frequency);

/// Where the three pulps are to an object.
using Grip = std::array<Eigen::Isometry3d, 3>;

/// The control points of a spherical pulp of radius 8 mm, centred on the origin; 320 is the reference scene's.
[[nodiscard]] Eigen::Matrix3Xd pulp_control_points(Eigen::Index leaves);

/// What every method is asked for.
struct GripTask {
  double band_m = 0.3e-3;
  Eigen::Index per_finger = 20;  ///< Contacts to be found.
};

/// Pulps pressed on the object, edges and all: each as deep as gives 1.3 times the contacts asked for, at most half its
/// radius.
[[nodiscard]] std::vector<Grip> random_grips(const KnownObject& object, const Eigen::Matrix3Xd& controls_m,
                                             const GripTask& task, int count, std::uint64_t seed);

/// A grip and its random walk by some 5 um and 0.5 mrad a step, there and back again, so that it can be repeated.
[[nodiscard]] std::vector<Grip> creeping_grip(const Grip& start, int count, std::uint64_t seed);

}  // namespace thenar
