// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>

#include "engine/finder/finder.h"
#include "engine/grasp/model.h"
#include "engine/grasp/scene.h"
#include "engine/results/verdict.h"

namespace thenar {

/// An object that a hand may be able to hold: one of the generators' with sizes of 8 to 120 mm, its frame anywhere in
/// it and turned at random, as a file's may be.
struct RandomObject {
  std::string name;  ///< "cylinder 31 x 84 mm"
  Shape shape;
  Eigen::Index points = 0;
  double mass_kg = 0.0;
  Eigen::Isometry3d X_OS = Eigen::Isometry3d::Identity();  ///< The generator's frame in the object's.
};

/// Number `seed` of them: spheres, boxes, cylinders, ellipsoids, superquadrics, mugs and plates in turns.
[[nodiscard]] RandomObject random_object(std::uint32_t seed);

/// The scene with this object in place of its own, and a grasp to be found.
[[nodiscard]] Scene scene_with(Scene scene, const RandomObject& object);

/// Its surface, in the object's frame.
[[nodiscard]] ImplicitSurface surface_of(const Scene& scene, const RandomObject& object);

/// The model of such a scene after the grasp was taken.
[[nodiscard]] Model model_with(const Scene& scene, const ImplicitSurface& surface, const FoundGrasp& grasp);

/// What became of a grasp that carries its object by 20 mm, after which it is pushed by 0.5 N.
struct HoldTrial {
  Verdict verdict;
  double first_move_m = 0.0;  ///< How far the object moves within 20 ms of the start,
  double first_load = 0.0;    ///< and how far a finger's load is then off what it is asked for, as a share.
};

/// In one loop at the scene's rates: 0.3 s at rest, 0.8 s of carrying in the direction `way_W`, 0.2 s of rest, 0.3 s of
/// push in a direction by chance, 0.2 s of rest.
[[nodiscard]] HoldTrial carry_and_push(Model model, const Eigen::Vector3d& way_W, std::uint32_t seed);

/// The least friction of contacts with which the grasp still holds its object for a second at rest, without a patch
/// that slides as a whole by more than 0.1 mm: bisected to 1 % between `low` and `high`. The controller's cones stay as
/// they are, and the model must have its control period in each step.
[[nodiscard]] double least_friction(const Model& model, double low, double high);

}  // namespace thenar
