#pragma once

#include <nlohmann/json.hpp>

#include "collision/triangle_mesh.h"
#include "engine/grasp/model.h"
#include "engine/loops/picture.h"

/// What a recording shows in 3-D to viewers that do not know Thenar, as messages of engine/formats/foxglove.h. Frames:
/// `world`, and in it `object`, `target` and `hand/<segment>`.
namespace thenar {

/// How long arrows are, and which pressure has the strongest colour.
inline constexpr double kContactArrow_m_per_N = 0.05, kFingerArrow_m_per_N = 0.015, kFullPressure_Pa = 100e3;

/// Bones and pulps in their segments' frames, sent once.
[[nodiscard]] nlohmann::ordered_json hand_entities(const Model& model, double time_s);
/// The surface in the object's frame: `surface`, or if that is empty a square for each of some thousand samples. Sent
/// once.
[[nodiscard]] nlohmann::ordered_json object_entities(const Model& model, double time_s,
                                                     const TriangleMesh& surface = {});

/// Where all frames are.
[[nodiscard]] nlohmann::ordered_json frame_transforms(const Model& model, const Picture& picture, double time_s);
/// Contact forces as thin arrows and the fingers' sums as thick ones, on the object: each begins where it acts.
[[nodiscard]] nlohmann::ordered_json force_entities(const Model& model, const Picture& picture, double time_s);
/// The pressed control points of the pulps as discs of their area, coloured by their pressure.
[[nodiscard]] nlohmann::ordered_json pressure_entities(const Model& model, const Picture& picture, double time_s);

}  // namespace thenar
