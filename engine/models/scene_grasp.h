// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/finder/finder.h"
#include "engine/finder/grasp_measures.h"
#include "engine/grasp/model.h"

namespace thenar {

/// Returns the finder's problem of a scene with a grasp to be found; it refers to the scene and the surface.
[[nodiscard]] FinderProblem finder_problem(const Scene& scene, const ImplicitSurface& object);

/// find_grasps() for such a scene, of which each was then tried in the engine, see rehearse(), and held its object:
/// those within the limits of their muscles first. Some more than `settings.best` are tried if need be; if all fail, it
/// searches once more, three times as long. Their postures are settled. The first one is that of a search for one
/// alone, and what follows is of a wider search, which is the same for any number up to 20: a rank names one grasp.
/// While grasps are tried, progress is called with a share of 1 and how many held; who then stops has these.
[[nodiscard]] FinderReport find_tried_grasps(const Scene& scene, const ImplicitSurface& object,
                                             const FinderSettings& settings = {}, const FinderProgress& progress = {});

/// Puts a found grasp into the scene: the hand with its fingers alone, posture, the object's pose, and the internal
/// force or the torques by which they press. The scene no longer asks for one.
void take_grasp(const FoundGrasp& grasp, Scene& scene);

/// Finds the grasp that the scene asks for, and takes it. Returns it in words. Throws ConfigError with the reason where
/// there is none.
[[nodiscard]] std::string find_scene_grasp(Scene& scene, const ImplicitSurface& object);

/// A measure as tables show it: times its factor, with its digits, without its unit.
[[nodiscard]] std::string shown_number(const GraspMeasure& measure, const FoundGrasp& grasp);

/// One paragraph: who holds where, how hard, and how well.
[[nodiscard]] std::string in_words(const FoundGrasp& grasp, const Hand& hand);
/// "the object is 81 mm wide where this hand opens 74 mm; a smaller object would help".
[[nodiscard]] std::string in_words(const Refusal& refusal);

}  // namespace thenar
