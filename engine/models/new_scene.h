// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/grasp/scene.h"

namespace thenar {

/// A user's object, and the hand that is to grasp it.
struct ObjectWish {
  std::filesystem::path object;         ///< A mesh or a cloud.
  std::filesystem::path hand = "hand";  ///< A file, or the name of a hand that comes with the program.
  double unit_m = 1.0;                  ///< Length unit of the object's file.
  double mass_kg = 0.1;                 ///< Mass, of uniform density.
  double friction = 0.6;                ///< Friction of the contacts.
  std::optional<double> press_N = {};   ///< Normal load of the least loaded finger; nothing: chosen.
};

/// Returns the scene, but for the object's centre of mass, which follows from its surface. Throws FileError, with the
/// name that is nearest where there is no such file, and ConfigError.
[[nodiscard]] Scene scene_of_object(const ObjectWish& wish);

/// The written scene.
struct NewScene {
  Eigen::Vector3d size_m;          ///< Size of the object.
  std::vector<std::string> notes;  ///< Changes to its points to make a surface of them.
};

/// Writes a scene to begin with as a commented file, which is not there yet. Throws FileError and ConfigError.
NewScene write_new_scene(const std::filesystem::path& file, const ObjectWish& wish);

/// Returns the schema that comes with the program; empty where it is missing, or where editors could not read its name.
[[nodiscard]] std::filesystem::path schema_file();

}  // namespace thenar
