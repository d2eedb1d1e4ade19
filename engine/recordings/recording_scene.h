// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "collision/triangle_mesh.h"
#include "engine/grasp/model.h"
#include "engine/loops/picture.h"

/// The 3-D view of a recording for viewers that do not know Thenar, as messages of engine/formats/foxglove.h. Frames:
/// `world`, and in it `object`, `target`, `hand/<segment>` and `around/<body>`.
namespace thenar {

/// Scales of the arrows, and the pressure of the strongest colour.
inline constexpr double kContactArrow_m_per_N = 0.05, kFingerArrow_m_per_N = 0.015, kFullPressure_Pa = 100e3;

/// Bones and pulps in their segments' frames, sent once.
[[nodiscard]] nlohmann::ordered_json hand_entities(const Model& model, double time_s);
/// The surface in the object's frame: `surface`, or if that is empty a square for each of some thousand samples; and
/// the bodies of an environment in theirs. Sent once.
[[nodiscard]] nlohmann::ordered_json object_entities(const Model& model, double time_s,
                                                     const TriangleMesh& surface = {});

/// Returns the poses of all frames; the target as a tick's record has it.
[[nodiscard]] nlohmann::ordered_json frame_transforms(const Model& model, const Picture& picture,
                                                      const Eigen::Isometry3d& X_WT, double time_s);
/// Contact forces as thin arrows, those of fingers and bodies in sum as thick ones, on the object: each begins where it
/// acts.
[[nodiscard]] nlohmann::ordered_json force_entities(const Model& model, const Picture& picture, double time_s);
/// The pressed control points of the pulps as discs of their area, coloured by their pressure.
[[nodiscard]] nlohmann::ordered_json pressure_entities(const Model& model, const Picture& picture, double time_s);

}  // namespace thenar
