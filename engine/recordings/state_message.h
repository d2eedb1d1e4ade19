// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "collision/triangle_mesh.h"
#include "engine/grasp/model.h"
#include "engine/loops/picture.h"
#include "engine/results/loop_figures.h"
#include "engine/results/recording.h"

/// Messages of a grasp for windows and recordings; docs/reference/window.md has the format.
namespace thenar {

inline constexpr std::uint16_t kMessageVersion = 3, kOldestMessageVersion = 1;  ///< Versions written, and still read.
enum class MessageKind : std::uint16_t { kGeometry = 1, kState = 2 };

/// A named part of a state message, or of a contact's row in it: float64 values begin .. begin + count.
struct Field {
  std::string name;
  std::string unit;  ///< Empty: a plain number.
  std::size_t begin = 0, count = 0;
};

/// Return the layout of a scene's state messages: docs/reference/window.md.
[[nodiscard]] std::vector<Field> state_fields(const Model& model);
[[nodiscard]] std::vector<Field> contact_fields(const Model& model);

/// Returns the constant part, which the page and a recording get first. `surface`: the object's shown_surface(), or
/// none.
[[nodiscard]] nlohmann::ordered_json scene_message(const Model& model, bool live, const TriangleMesh& surface = {});

/// Returns the pose of a scene's hand at given angles, in the words of a scene message: its `fingers` and `segments`,
/// and `poses`, 12 numbers a segment as a state has them.
[[nodiscard]] nlohmann::ordered_json posture_json(const Hand& hand, const JointVector& q);

/// Returns the points of the object, at most 40 000 of them, and of the pulps, and the object's surface, the same as in
/// the scene's message.
[[nodiscard]] std::string geometry_message(const Model& model, const TriangleMesh& surface = {});

/// Writes one instant. `tick`: record of the picture's tick. `muscle_forces_N`: those that its control tick asked for;
/// not read in a scene without muscles. The message replaces what is in `bytes`.
void write_state_message(const Model& model, const Picture& picture, const TickRecord& tick,
                         const Eigen::VectorXd& muscle_forces_N, const LoopFigures& loops, std::string& bytes);

/// Returns the numbers of a state message; empty if it is none of a version that is read.
[[nodiscard]] std::vector<double> read_state_message(std::string_view bytes);

}  // namespace thenar
