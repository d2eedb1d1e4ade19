// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "thenar/eigen_layout.h"

/// Messages in JSON of schemas that robot viewers support: 3-D entities, frames and log lines as published by Foxglove
/// (github.com/foxglove/foxglove-sdk, schemas/jsonschema). Lengths in m.
namespace thenar::foxglove {

using Json = nlohmann::ordered_json;

/// A color: red, green, blue, opacity, 0 to 1.
using Color = Eigen::Vector4d;

/// Return the published structure of the messages below, as JSON Schema.
[[nodiscard]] Json scene_update_schema();
[[nodiscard]] Json frame_transforms_schema();
[[nodiscard]] Json log_schema();

/// Returns an entity without primitives, to which those below are added: entity["arrows"].push_back(arrow(...)). It is
/// fixed in the frame, with `moves` also when the frame moves later, and persists until replaced by one of the same id.
[[nodiscard]] Json entity(const std::string& id, const std::string& frame, double time_s, bool moves);

/// Returns an item of "arrows": from `tail` to `tip`, which differ.
[[nodiscard]] Json arrow(const Eigen::Vector3d& tail, const Eigen::Vector3d& tip, double thickness_m,
                         const Color& color);
/// Returns an item of "spheres": an ellipsoid with these semi-axes along x, y and z.
[[nodiscard]] Json sphere(const Eigen::Isometry3d& pose, const Eigen::Vector3d& half_m, const Color& color);
/// Returns an item of "cylinders": along z, its middle at the pose.
[[nodiscard]] Json cylinder(const Eigen::Isometry3d& pose, double radius_m, double length_m, const Color& color);
/// Returns an item of "cylinders" between two points, which differ.
[[nodiscard]] Json rod(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius_m, const Color& color);
/// Returns an item of "triangles": three indices each.
[[nodiscard]] Json triangles(const Eigen::Matrix3Xd& points_m, const std::vector<int>& indices, const Color& color);

/// Returns a SceneUpdate of entities. `instead`: it replaces all earlier ones of the topic.
[[nodiscard]] Json scene_update(std::vector<Json> entities, double time_s, bool instead);

/// Returns an item of a FrameTransforms' "transforms".
[[nodiscard]] Json transform(const std::string& parent, const std::string& child, const Eigen::Isometry3d& pose,
                             double time_s);

enum class LogLevel { kInfo = 2, kWarning = 3, kError = 4 };
[[nodiscard]] Json log(LogLevel level, const std::string& text, double time_s);

}  // namespace thenar::foxglove
