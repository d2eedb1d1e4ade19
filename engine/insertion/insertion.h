// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "engine/environment/environment.h"
#include "engine/insertion/peg_theory.h"
#include "engine/results/scene_run.h"

namespace thenar {

// The insertion of a peg into a hole, in terms of Whitney's theory [Whitney 1982, J Dyn Sys Meas Control 104:65]. All
// quantities are in one plane through the hole's axis: that of the peg's tilt at the start, or else of its lateral
// offset. Its x points in the direction of the tilt of the peg's upper end, z out of the hole.

/// The contact state of peg and hole.
enum class PegTouch {
  kFree,       ///< No contact.
  kPlate,      ///< The peg's end is on the plate around the hole, or on the rim of its mouth.
  kChamfer,    ///< The peg's end is on the chamfer, which moves it laterally.
  kOnePoint,   ///< One point of the peg is on the wall.
  kTwoPoints,  ///< Points at opposite sides: the mouth holds the peg on one side, the wall its end on the other.
  kLine,       ///< Points at one side: the peg lies along the wall.
  kBottom,     ///< The peg stands on the bottom.
};
inline constexpr std::array kPegTouches = {PegTouch::kFree,     PegTouch::kPlate,     PegTouch::kChamfer,
                                           PegTouch::kOnePoint, PegTouch::kTwoPoints, PegTouch::kLine,
                                           PegTouch::kBottom};

/// Returns "free", "plate", "chamfer", "one point", "two points", "line" or "bottom".
[[nodiscard]] const char* to_string(PegTouch touch);
/// Describes it in words: "the mouth holds the peg on one side, the wall its end on the other".
[[nodiscard]] const char* in_words(PegTouch touch);

/// The object of a scene as a peg, and its hole.
struct PegScene {
  std::size_t body = 0;  ///< Index of the hole among the environment's bodies.
  PegShape shape;
  double hole_depth_m = 0.0;
  double length_m = 0.0;
  double end = -1.0;  ///< The peg's inserted end is at z = end * length_m / 2, object frame.
  Eigen::Matrix3d R_EP = Eigen::Matrix3d::Identity();  ///< Columns x, y, z of the plane, hole's frame; y across it.
  double tilt_rad = 0.0, aside_m = 0.0;                ///< Tilt and offset of the peg at the start, in the plane.
};

/// Returns the first hole of the scene, and its cylinder. Throws ConfigError, in the name of `file`, if the object is
/// no cylinder, if there is no hole, or if the peg is not thinner than it.
[[nodiscard]] PegScene peg_scene(const Scene& scene, const std::string& file);

/// A tick of an insertion. Forces are those of the hand on the peg, which balance those of the environment.
struct PegTick {
  double time_s = 0.0;
  PegTouch touch = PegTouch::kFree;
  double depth_m = 0.0;  ///< Depth of the middle of the peg's end below the plate.
  double tilt_rad = 0.0;
  double push_N = 0.0;          ///< F_z, into the hole.
  double aside_N = 0.0;         ///< F_x.
  double moment_Nm = 0.0;       ///< M about the middle of the peg's end, about y: more tilt.
  double across_N = 0.0;        ///< Force out of the plane, zero in theory.
  double normal_N = 0.0;        ///< Sum of normal forces.
  double going_m_per_s = 0.0;   ///< Speed of the peg into the hole.
  double coming_m_per_s = 0.0;  ///< Speed of the hole towards the peg.
  bool wedged = false;          ///< True if two contacts stick, and the line through them is in both friction cones.

  /// Tests whether the hole moves faster than 0.1 mm/s: creep at rest is no insertion.
  [[nodiscard]] bool comes() const { return coming_m_per_s > 1e-4; }
};

/// Consecutive ticks with the same contact state.
struct PegPhase {
  PegTouch touch = PegTouch::kFree;
  std::size_t begin = 0, end = 0;  ///< Range of the ticks: [begin, end).
};

/// The outcome of an insertion.
enum class PegEnd {
  kIn,       ///< The peg entered as far as the hole moved, less the hand's compliance.
  kOutside,  ///< It never came below the chamfer.
  kWedged,   ///< Two contacts within the friction cones held it.
  kJammed,   ///< It stopped in the moving hole without being wedged.
  kLost,     ///< Neither, but the hand lost it.
};
/// Returns "in", "outside", "wedged", "jammed" or "lost".
[[nodiscard]] const char* to_string(PegEnd end);

struct InsertionStudy {
  PegScene peg;
  Verdict verdict;
  std::vector<PegTick> ticks;
  std::vector<PegPhase> phases;  ///< Phases; those of less than 5 ms are merged with the one before.
  PegEnd end = PegEnd::kOutside;
  double asked_m = 0.0;                   ///< Depth at the end for a rigid hand.
  std::optional<std::size_t> two_points;  ///< First tick with two points.
  std::optional<std::size_t> wedged;      ///< First tick that wedges.
  std::optional<std::size_t> stopped;     ///< First tick from which on the peg stands still in a moving hole.
  std::vector<PegForce> theory;           ///< Theory, for a controller that is a spring; else empty.

  [[nodiscard]] double deepest_m() const;
  /// Returns the largest error of F_z against the theory at the same depth while both have this contact state, over the
  /// theory's largest there. NaN if they never do, or without a theory.
  [[nodiscard]] double off_theory(PegTouch touch) const;
};

/// The position of a tick in the jamming diagram of its depth. The diagram holds for small tilts: with a tilt theta the
/// ratios have a relative error of theta (mu + 1 / mu).
struct JammingPoint {
  double lambda = 0.0;  ///< l / (2 r mu), l below the chamfer.
  double across = 0.0;  ///< F_x / F_z
  double moment = 0.0;  ///< M / (r F_z)
  /// Distance inside the diagram's four lines, over 1 + lambda or 1 / mu: 0 on them, where the peg slides; negative:
  /// outside, where it jams.
  double margin = 0.0;
};
/// Computes the point; nothing if the peg is not pushed, or is not below the chamfer.
[[nodiscard]] std::optional<JammingPoint> jamming_point(const PegScene& peg, const PegTick& tick);

/// Runs the scene on one thread and records its peg. Deterministic.
[[nodiscard]] InsertionStudy study_insertion(const Model& model, const PegScene& peg, RunSettings settings = {});

}  // namespace thenar
