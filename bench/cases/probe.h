// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "bench/cases/scene_run.h"
#include "engine/grasp/scene.h"

/// One fingertip against an object that goes where the caller puts it, looked at from outside: deformed points and
/// forces of contacts against a surface that the caller knows.
namespace thenar::truth {

/// What a probe presses, and how.
struct Probe {
  Shape shape;
  Eigen::Index points = 12000;  ///< Samples of the shape.
  Eigen::Index leaves = 320;    ///< Control points of the pulp; 0: a rigid tip.
  double friction = 0.0;
  double frame_s = 1e-3;                             ///< How often contacts are found.
  double relaxation_s = 0.0;                         ///< Of the pulp.
  Eigen::Vector3d half_m = Eigen::Vector3d::Zero();  ///< Semi-axes of a pulp that is an ellipsoid; 0: a sphere.
  double object_modulus_Pa = 0.0;                    ///< E* of an elastic object; 0: it is rigid.
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
};

inline constexpr double kProbeRadius_m = 8e-3, kProbeModulus_Pa = 0.24e6;

/// A fingertip whose centre stays at the world's origin and that faces along x, and an object that goes where the
/// caller puts it: an experiment under displacement control.
[[nodiscard]] Scene scene_of(const Probe& probe);

/// A loaded contact of the last tick: where the deformed point is, and the force on the object, in the object's frame.
struct LoadedPoint {
  Eigen::Vector3d x_O, f_O;
};
[[nodiscard]] std::vector<LoadedPoint> loaded_points(const Model& model, const GraspRun& run);

/// Friction and normal force of a point against an outward normal that is known.
struct Split {
  double normal_N, friction_N;
};
[[nodiscard]] Split split(const Eigen::Vector3d& f, const Eigen::Vector3d& outward);

/// A place beside a surface: the outward normal over it, and how far above it is. Object frame.
struct Over {
  Eigen::Vector3d outward;
  double above_m;
};
using Surface = std::function<Over(const Eigen::Vector3d&)>;

/// A cylinder about z.
[[nodiscard]] Surface rod_surface(double radius_m);

/// A torus about z: a rod of this radius, bent to a ring.
[[nodiscard]] Surface ring_surface(double ring_m, double rod_m);

/// Where a probe touches an object at first, and along which circle of the surface it then slides. Object frame.
struct Track {
  Eigen::Vector3d s_m, outward, along;  ///< Unit vectors at right angles.
  double curvature_per_m = 0.0;         ///< Of the circle: > 0 where the object is round.
};

/// The object's pose after it has gone `way_m` along the track under the probe, pressed in by `depth_m`.
[[nodiscard]] Eigen::Isometry3d pose_on(const Track& track, double depth_m, double way_m);

/// What loaded points bear in the last ticks of a slide.
struct Rubbed {
  double least_ratio = 1e9, largest_ratio = 0.0;  ///< Of friction over normal force, in a point.
  double against_N = 0.0, normal_N = 0.0;         ///< Sums of what is against the slip, and along the exact normals.
  double off_m = 0.0;                             ///< The farthest from the surface.
  int points = 0;

  [[nodiscard]] double ratio() const { return against_N / normal_N; }
};

/// Slides the object along a way, poses by the share of the whole, and looks at the last 20 ticks.
[[nodiscard]] Rubbed slide(const Probe& probe, int ticks, const std::function<Eigen::Isometry3d(double)>& way,
                           const Surface& surface);

/// Likewise along a track, 1 mm deep and at 10 um a tick.
[[nodiscard]] Rubbed slide(Probe probe, const Track& track, double way_m, const Surface& surface);

}  // namespace thenar::truth
