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

/// What a scene models beyond rigid bodies that touch at points and a hand that knows all, and could do without.
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
  kTouch,      ///< What fingertips feel: without, no reflex, and cones of the friction that is expected.
  kReflex,
  kAnticipation,
  kFeedbackDelay,
  kMuscleStiffness,  ///< Without, muscles give the forces that they are asked for, however long they are.
  kActivation,       ///< Without, at once.
  kEnvironment,      ///< What it does to the object counts as a finger's force does.
};
/// Those that save most first: so they are tried.
inline constexpr std::array kParts{
    Part::kFingertips,      Part::kSoftObject,    Part::kDetail,          Part::kMuscles,    Part::kObjectMemory,
    Part::kFingertipMemory, Part::kStiffening,    Part::kPulpShape,       Part::kTouch,      Part::kReflex,
    Part::kAnticipation,    Part::kFeedbackDelay, Part::kMuscleStiffness, Part::kActivation, Part::kEnvironment};

/// In words, with the scene's key: "muscles (control.muscles)".
[[nodiscard]] const char* to_string(Part part);

/// Whether the scene names the part.
[[nodiscard]] bool has(const Scene& scene, Part part);

/// The scene as if it had not named the part.
[[nodiscard]] Scene leave_out(Scene scene, Part part);

/// Where the object was and what fingers and environment did to it, tick by tick: lists of one length.
struct GraspPath : Watcher {
  std::vector<Eigen::Isometry3d> X_WO;
  std::vector<FingerForces> force_N;  ///< On the object, world axes.
  std::vector<PerFinger<PatchReport>> patch;
  std::vector<Eigen::Vector3d> environment_N;  ///< On the object, likewise; zero without one.

  bool see_tick(const Tick& tick) override;
};

/// How far one path is off another, in the ticks that both have from `first` on.
struct PathDeviation {
  double position_rms_m = 0.0, position_final_m = 0.0;
  double rotation_rms_rad = 0.0, rotation_final_rad = 0.0;
  double force = 0.0;   ///< rms of what the forces differ by, all together, over that of the reference's.
  double moment = 0.0;  ///< Likewise of the patches' torsions, over the most that the reference's could carry: M_max.
  double margin = 0.0;  ///< rms of what the margins of loaded fingers differ by; 1 where one path alone loads a finger.
};
[[nodiscard]] PathDeviation deviation(const GraspPath& path, const GraspPath& reference, std::size_t first);

/// A scene run in one loop, as run_scene does. All but the time is the same for the same scene, to the last bit.
struct PathRun {
  GraspPath path;
  Verdict verdict;
  bool ended = false;  ///< It came to the scene's end.
  double us = 0.0;     ///< A tick takes: median contact tick, and as much of the median control tick as falls to each.
};
[[nodiscard]] PathRun run_path(const Model& model);

/// What becomes of a scene without a part.
struct PartEffect {
  Part part = Part::kFingertips;
  int level = 0;  ///< Of detail, without it.
  Verdict verdict;
  PathDeviation error;  ///< Against the full model, once the grip has built up (kMeasuredFrom_s).
  double us = 0.0;      ///< PathRun's.
  bool alike = false;   ///< It came to its end with the same outcome.
  bool within = false;  ///< And the error is within the scene's tolerance.
  bool idle = false;    ///< Of the environment: nothing of it ever touches the object.
};

/// Is called before each run, with words that say which it is.
using OnRun = std::function<void(const std::string&)>;

/// Runs a scene once without each part that it names. `full` is its own run.
[[nodiscard]] std::vector<PartEffect> ablate(const Model& model, const PathRun& full, const OnRun& on_run = {});

/// What is left of a scene if one part after the other is left out, in the order of kParts, as long as all that is left
/// out together stays within the tolerance. Errors decide, not times: the same scene keeps the same parts.
struct NeededParts {
  Scene scene;
  /// Each together with those before it that are within: of levels the coarsest that is, and the finest that is not.
  std::vector<PartEffect> tried;
};
[[nodiscard]] NeededParts needed_parts(const Model& model, const PathRun& full, const OnRun& on_run = {});

/// to_string(), and how far detail goes: "level of detail (contact.level) to 4".
[[nodiscard]] std::string title(const PartEffect& effect);
/// The rms: "2.1 um, 0.0029 deg, forces 0.21 %, moments 1.3 %, margins 0.002".
[[nodiscard]] std::string in_words(const PathDeviation& error);
/// How far the scene is off, or how else it ends.
[[nodiscard]] std::string in_words(const PartEffect& effect);

/// The model as its scene wants it: as it is or, for `model: auto`, with the needed parts, and Scene::left_out says
/// which were left out or not, and why. Then it runs the scene several times.
[[nodiscard]] Model as_needed(Model model);

}  // namespace thenar
