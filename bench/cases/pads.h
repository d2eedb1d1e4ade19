// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/grasp/scene.h"

namespace thenar {

/// A fingertip of 8 mm on a slide, which presses with a constant force.
struct Pad {
  Eigen::Vector3d at_m, inward;  ///< Where it first touches the surface, and the unit vector it presses along.
  double force_N = 2.0;
};

inline constexpr double kPad_m = 8e-3;

/// Pads that press on an object, each free to move along its normal alone: a grasp whose limits can be worked out by
/// hand. Nobody controls it.
struct Pads {
  Shape shape = SphereShape{25e-3};
  std::vector<Pad> pads;         ///< Object frame.
  double curvature_per_m = 0.0;  ///< Of the surface there, where it is the same in all directions.
  double depth_m = 0.8e-3;       ///< How deep the rest shapes are pressed in at the start.
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};
  double mass_kg = 0.1;
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();  ///< Object frame.
  double friction = 0.8;
};

/// Pads evenly round the z axis, on a surface whose radius there is `radius_m`.
Pads pads_round(const Shape& shape, double radius_m, int count = 3);

/// A pad against two of half its force, `apart_m` from one another along z: a pinch across x of an object `width_m`
/// wide.
Pads pads_across(const Shape& shape, double width_m, double apart_m);

/// The scene of it: fingertips on slides, which 1 N moves at 0.1 m/s.
Scene scene_of(const Pads& pads);

/// Whether the pads hold the object: after the grip has built up its centre of mass falls no more, and what little it
/// has turned leaves the lever of its weight as it was.
bool hold(const Pads& pads);

/// The most mass that the pads hold by friction where a pad's friction F_t and its torsion M can be all that the
/// ellipsoid between them encloses [Goyal, Ruina, Papadopoulos 1991],
///     (F_t / (mu F_n))^2 + (M / M_max)^2 <= 1,   M_max = 3 pi / 16 mu F_n a,   a^3 = 3/4 F_n / (E* (1/R + curvature)),
/// M_max of Hertz's pressure on a disc of radius a. By the upper bound theorem it is the least that the pads dissipate,
/// over all motions of the object in which the weight of 1 kg does work of 1: a sum of norms, which reweighted least
/// squares find [Weiszfeld 1937]. Requires normal forces in balance.
double most_mass_kg(const Pads& pads, double reduced_modulus_Pa);

}  // namespace thenar
