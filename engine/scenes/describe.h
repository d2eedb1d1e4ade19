// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "engine/grasp/scene.h"
#include "engine/scenes/visitor.h"

/// The description of a scene file: each key once, beside the field of Scene that its value belongs to. The table of
/// keys, the reader and the writer are visitors of it (engine/scenes/visitor.h).
namespace thenar {

/// A scene, and what its file says that the scene itself does not know.
struct SceneFile {
  Scene scene;
  std::filesystem::path hand;                  ///< The hand's file.
  std::vector<std::string> fingers;            ///< Those that the hand has here; empty: all.
  bool is_readable = true;                     ///< True if the files that it names could be read; others are refused.
  std::optional<double> taken_squeeze_N = {};  ///< Squeeze of a grasp that is taken from another scene.
};

/// The whole file.
void describe(Visitor& v, SceneFile& file);

// Its parts.
void describe_slides(Visitor& v, Scene& scene);
void describe_hand(Visitor& v, SceneFile& file, bool is_found, bool is_controlled);
void describe_grasp(Visitor& v, SceneFile& file, bool is_controlled);
void describe_object(Visitor& v, ObjectSettings& object, bool is_found, bool fingertips_deform);
/// `is_pressed`: a grasp that is found says how hard the fingers squeeze.
void describe_control(Visitor& v, SceneFile& file, bool is_pressed);
/// `scene` has gravity, and whether a grasp is to be found.
void describe_environment(Visitor& v, Environment& environment, const Scene& scene);
void describe_task(Visitor& v, Scene& scene);

// Elements common to several parts.
void describe(Visitor& v, BoxShape& box);
void describe(Visitor& v, SphereShape& sphere);
void describe(Visitor& v, CylinderShape& cylinder);
/// A PID of the object's position, or of its rotation.
void describe_position_gains(Visitor& v, PidGains& gains);
void describe_rotation_gains(Visitor& v, PidGains& gains);
/// A vector of any length but zero, which is made a unit vector.
void describe_direction(Visitor& v, const KeyRow& row, Eigen::Vector3d& direction);
void describe_direction(Visitor& v, const KeyRow& row, std::optional<Eigen::Vector3d>& direction);

/// A rotation: a matrix, or a map with an axis and an angle, with angles about three axes, or with a quaternion.
void describe_rotation(Visitor& v, const KeyRow& row, Eigen::Matrix3d& rotation);
void describe_rotation(Visitor& v, const KeyRow& row, std::optional<Eigen::Matrix3d>& rotation);
/// The pose of a body by two keys, as their rows tell: position, and a rotation in any of its forms.
void describe_pose(Visitor& v, const KeyRow& position, const KeyRow& rotation, Eigen::Isometry3d& X);

/// A hand's file as a scene names it: beside the scene, or one that comes with the program.
[[nodiscard]] std::filesystem::path found_hand(const std::filesystem::path& beside);
/// Fingers by their names, and the other way round; a name that the hand does not have, or a second time, is refused.
[[nodiscard]] std::vector<std::string> names_of(const Hand& hand, const std::vector<int>& fingers);
[[nodiscard]] std::vector<int> fingers_named(Visitor& v, const Hand& hand, const std::vector<std::string>& names);
/// Refuses what a grasp that is found says instead.
void refuse_found(Visitor& v, std::initializer_list<std::string_view> keys);

}  // namespace thenar
