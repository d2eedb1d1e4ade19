// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "engine/control/control.h"
#include "engine/grasp/model.h"
#include "engine/grasp/patches.h"
#include "engine/grasp/state.h"
#include "engine/loops/run.h"
#include "engine/results/verdict.h"

namespace thenar {

/// An optional part of a model, beyond rigid bodies with point contacts and a hand that knows all.
enum class Part {
  kFingertips,  ///< Deformation of the fingertips, and of the object with it: without, a rigid contact point each, and
                ///< the controller knows that they are rigid.
  kSoftObject,
  kDetail,  ///< Control points: without, the next coarser level. A level chosen by contact.force_error is none.
  kMuscles,
  kObjectMemory,
  kFingertipMemory,
  kStiffening,
  kPulpShape,  ///< Ellipsoids and capsules: without, spheres that touch where the pulps face, as round as these are.
  kTouch,      ///< Tactile signals of fingertips: without, no reflex, and cones of the expected friction.
  kReflex,
  kAnticipation,
  kFeedbackDelay,
  kMuscleStiffness,  ///< Without, muscles give the commanded forces at any length.
  kActivation,       ///< Without, at once.
  kEnvironment,      ///< Its forces on the object count as those of a finger.
};
/// The parts in the order of trials: those that save most first.
inline constexpr std::array kParts{
    Part::kFingertips,      Part::kSoftObject,    Part::kDetail,          Part::kMuscles,    Part::kObjectMemory,
    Part::kFingertipMemory, Part::kStiffening,    Part::kPulpShape,       Part::kTouch,      Part::kReflex,
    Part::kAnticipation,    Part::kFeedbackDelay, Part::kMuscleStiffness, Part::kActivation, Part::kEnvironment};

/// Describes a part, with the scene's key: "muscles (control.muscles)".
[[nodiscard]] const char* to_string(Part part);

/// Tests whether the scene has the part.
[[nodiscard]] bool has(const Scene& scene, Part part);

/// Returns the scene without the part.
[[nodiscard]] Scene leave_out(Scene scene, Part part);

/// The pose of the object and the forces of fingers and environment on it, tick by tick: lists of one length.
struct GraspPath : Watcher {
  std::vector<Eigen::Isometry3d> X_WO;
  std::vector<FingerForces> force_N;  ///< On the object, world axes.
  std::vector<PerFinger<PatchReport>> patch;
  std::vector<Eigen::Vector3d> environment_N;  ///< On the object, likewise; zero without one.

  bool see_tick(const Tick& tick) override;
};

/// The deviation of one path from another, over their common ticks from `first` on.
struct PathDeviation {
  double position_rms_m = 0.0, position_final_m = 0.0;
  double rotation_rms_rad = 0.0, rotation_final_rad = 0.0;
  double force = 0.0;   ///< rms of the force differences, all together, over that of the reference's.
  double moment = 0.0;  ///< rms of the torsions' differences, over the most that the reference could carry: M_max.
  double margin = 0.0;  ///< rms of the margins' differences of loaded fingers; 1 where one path alone loads a finger.
};
[[nodiscard]] PathDeviation deviation(const GraspPath& path, const GraspPath& reference, std::size_t first);

/// A scene run in one loop, as by run_scene. All but the time is reproducible to the last bit.
struct PathRun {
  GraspPath path;
  Verdict verdict;
  bool ended = false;  ///< True if it came to the scene's end.
  double us = 0.0;     ///< Time per tick: median contact tick, and its share of the median control tick.
};
[[nodiscard]] PathRun run_path(const Model& model);

/// The effect on a scene of leaving out a part.
struct PartEffect {
  Part part = Part::kFingertips;
  int level = 0;  ///< Level of detail, without it.
  Verdict verdict;
  PathDeviation error;  ///< Relative to the full model, after the grip has built up (kMeasuredFrom_s).
  double us = 0.0;      ///< PathRun's.
  bool alike = false;   ///< True if it came to its end with the same outcome.
  bool within = false;  ///< True if the error is within the scene's tolerance, too.
  bool idle = false;    ///< For the environment: true if it never touches the object.
};

/// A callback before each run, with its description.
using OnRun = std::function<void(const std::string&)>;

/// Runs a scene once without each of its parts. `full` is its own run.
[[nodiscard]] std::vector<PartEffect> ablate(const Model& model, const PathRun& full, const OnRun& on_run = {});

/// The needed parts of a scene: parts are left out in the order of kParts, as long as the error of all omissions
/// together stays within the tolerance. Errors decide, not times: the same scene keeps the same parts.
struct NeededParts {
  Scene scene;
  /// Effects, each together with the accepted ones before it; of levels the coarsest accepted and the finest rejected.
  std::vector<PartEffect> tried;
};
[[nodiscard]] NeededParts needed_parts(const Model& model, const PathRun& full, const OnRun& on_run = {});

/// Returns to_string(), and the level of detail: "level of detail (contact.level) to 4".
[[nodiscard]] std::string title(const PartEffect& effect);
/// Describes the rms: "2.1 um, 0.0029 deg, forces 0.21 %, moments 1.3 %, margins 0.002".
[[nodiscard]] std::string in_words(const PathDeviation& error);
/// Describes the error of the scene, or its other outcome.
[[nodiscard]] std::string in_words(const PartEffect& effect);

/// Returns the model unchanged or, for `model: auto`, with the needed parts, and the reasons in Scene::left_out. In
/// that case it runs the scene several times.
[[nodiscard]] Model as_needed(Model model);

}  // namespace thenar
