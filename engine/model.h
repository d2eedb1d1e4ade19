#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "collision/implicit_surface.h"
#include "engine/pulp.h"
#include "engine/scene.h"

namespace thenar {

/// The share of its radius by which a fingertip may be pressed in, or have moved against the object since a frame's
/// snapshot: beyond it no law used here holds, and other points touch than those of the frame.
inline constexpr double kTrustPerRadius = 0.5;

/// A scene made ready to run: its data, and what is computed from them once.
struct Model {
  explicit Model(Scene s);

  Scene scene;
  std::vector<std::string> object_notes;  ///< What was mended in the object's surface, one sentence each.
  ImplicitSurface object;
  std::vector<Pulp> pulps;        ///< One a finger, or none: rigid point contacts.
  Eigen::Matrix3Xd fine_m;        ///< Object's samples that control points may pass by (fine_parts): usually none.
  Eigen::Index max_contacts = 0;  ///< Capacity of a frame, all fingers together.

  [[nodiscard]] bool deformable() const { return !pulps.empty(); }
  /// Whether a control period begins with this step. The periods need not hold a whole number of steps.
  [[nodiscard]] bool control_is_due(std::int64_t tick) const;
  /// Where the object should be: its start pose moved by the task.
  [[nodiscard]] Eigen::Isometry3d target(double time_s) const;
  /// What the task does to the object at `time_s`, world axes.
  [[nodiscard]] Eigen::Vector3d push(double time_s) const;
};

}  // namespace thenar
