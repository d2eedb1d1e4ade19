// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <string_view>

#include "engine/grasp/scene.h"
#include "engine/scenes/visitor.h"

namespace thenar {

/// Refuses a point of the object that does not lie in the box around it. Of a shape from a file the model knows.
void check_is_in_object(Visitor& v, std::string_view key, const Eigen::Vector3d& point_m, const Shape& shape);

/// A box in mm: "-25 .. 25, -25 .. 25, -25 .. 25 mm".
[[nodiscard]] std::string in_words(const Eigen::AlignedBox3d& box);

}  // namespace thenar
