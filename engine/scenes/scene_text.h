// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "engine/grasp/scene.h"

namespace thenar {

/// Contents of a scene's text that the scene itself does not know.
struct SceneTextNotes {
  std::filesystem::path hand;    ///< The hand's file, as the scene's text is to name it.
  std::filesystem::path object;  ///< The object's file, if its shape is from one.
  std::string about;             ///< The comment that it begins with, one line.
  std::string grasp;             ///< A comment on the grasp, of any length; may be empty.
  std::filesystem::path schema;  ///< By which editors complete the file; may be empty.
  bool names_fingers = false;    ///< The hand has fewer fingers than its file: name them.
};

/// A complete scene file with comments, which load_scene() reads back to the same scene: one with a grasp to be found
/// (Scene::grasp) or with posture and pose. A value that a file has without naming it is left out.
[[nodiscard]] std::string scene_text(const Scene& scene, const SceneTextNotes& notes);

/// A scene to begin with: a hand grasps an object from a file, lifts nothing yet, and is to find how. `friction` is
/// that of the contacts; the controller's cones take seven tenths of it.
[[nodiscard]] Scene scene_to_begin_with(const Hand& hand, const CloudShape& object, double mass_kg, double friction);

/// The centroid of the solid that a surface encloses, from its samples [m], which need not be evenly dense; the middle
/// of its box if they enclose none.
[[nodiscard]] Eigen::Vector3d enclosed_centroid_m(const PointCloud& cloud);

}  // namespace thenar
