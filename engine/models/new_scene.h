#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/grasp/scene.h"

namespace thenar {

/// An object of one's own, and the hand that is to grasp it.
struct ObjectWish {
  std::filesystem::path object;         ///< A mesh or a cloud.
  std::filesystem::path hand = "hand";  ///< A file, or the name of a hand that comes with the program.
  double unit_m = 1.0;                  ///< What 1 in the object's file measures.
  double mass_kg = 0.1;                 ///< Throughout as dense.
  double friction = 0.6;                ///< Of the contacts.
  std::optional<double> press_N = {};   ///< Normal load of the least loaded finger; nothing: chosen.
};

/// The scene, but for the object's centre of mass, which its surface tells. Throws FileError, with the name that is
/// nearest where there is no such file, and ConfigError.
[[nodiscard]] Scene scene_of_object(const ObjectWish& wish);

/// What was written.
struct NewScene {
  Eigen::Vector3d size_m;          ///< Of the object.
  std::vector<std::string> notes;  ///< What was done to its points to make a surface of them.
};

/// Writes a scene to begin with as a commented file, which is not there yet. Throws FileError and ConfigError.
NewScene write_new_scene(const std::filesystem::path& file, const ObjectWish& wish);

/// The schema that comes with the program; empty where it is missing, or where editors could not read its name.
[[nodiscard]] std::filesystem::path schema_file();

}  // namespace thenar
