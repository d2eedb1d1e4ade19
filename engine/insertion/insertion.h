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

// How a peg goes into a hole, in the terms of Whitney's theory [Whitney 1982, J Dyn Sys Meas Control 104:65]. All is
// looked at in one plane through the hole's axis: that in which the peg is tilted as the run begins, or else aside.
// Its x points where the peg's upper end leans to, z out of the hole.

/// How peg and hole touch.
enum class PegTouch {
  kFree,       ///< They do not.
  kPlate,      ///< The peg's end is on the plate around the hole, or on the rim of its mouth.
  kChamfer,    ///< The peg's end is on the chamfer, which moves it aside.
  kOnePoint,   ///< One point of the peg is on the wall.
  kTwoPoints,  ///< Points at opposite sides: the mouth holds the peg on one side, the wall its end on the other.
  kLine,       ///< Points at one side: the peg lies along the wall.
  kBottom,     ///< It stands on the bottom.
};
inline constexpr std::array kPegTouches = {PegTouch::kFree,     PegTouch::kPlate,     PegTouch::kChamfer,
                                           PegTouch::kOnePoint, PegTouch::kTwoPoints, PegTouch::kLine,
                                           PegTouch::kBottom};

/// "free", "plate", "chamfer", "one point", "two points", "line", "bottom".
[[nodiscard]] const char* to_string(PegTouch touch);
/// What that is, in words: "the mouth holds the peg on one side, the wall its end on the other".
[[nodiscard]] const char* in_words(PegTouch touch);

/// The object of a scene as a peg, and the hole that it is to go into.
struct PegScene {
  std::size_t body = 0;  ///< The hole's, among the environment's bodies.
  PegShape shape;
  double hole_depth_m = 0.0;
  double length_m = 0.0;
  double end = -1.0;  ///< The peg's end that goes in is at z = end * length_m / 2, object frame.
  Eigen::Matrix3d R_EP = Eigen::Matrix3d::Identity();  ///< Columns x, y, z of the plane, hole's frame; y across it.
  double tilt_rad = 0.0, aside_m = 0.0;                ///< Of the peg against the hole as the run begins, in the plane.
};

/// The first hole of the scene, and its cylinder. Throws ConfigError, in the name of `file`, if the object is no
/// cylinder, if there is no hole, or if the peg is not thinner than it.
[[nodiscard]] PegScene peg_scene(const Scene& scene, const std::string& file);

/// A tick of an insertion. Forces are those by which the hand pushes the peg: what the environment pushes back with.
struct PegTick {
  double time_s = 0.0;
  PegTouch touch = PegTouch::kFree;
  double depth_m = 0.0;  ///< Of the middle of the peg's end below the plate.
  double tilt_rad = 0.0;
  double push_N = 0.0;          ///< F_z, into the hole.
  double aside_N = 0.0;         ///< F_x.
  double moment_Nm = 0.0;       ///< M about the middle of the peg's end, about y: more tilt.
  double across_N = 0.0;        ///< Out of the plane, where theory has nothing.
  double normal_N = 0.0;        ///< Sum of normal forces.
  double going_m_per_s = 0.0;   ///< How fast the peg goes into the hole,
  double coming_m_per_s = 0.0;  ///< and how fast the hole comes.
  bool wedged = false;          ///< Two contacts stick, and the line through them is in both friction cones.

  /// The hole comes, faster than 0.1 mm/s: what lies and creeps is no insertion.
  [[nodiscard]] bool comes() const { return coming_m_per_s > 1e-4; }
};

/// Ticks in a row that touch alike.
struct PegPhase {
  PegTouch touch = PegTouch::kFree;
  std::size_t begin = 0, end = 0;  ///< Among the ticks: [begin, end).
};

/// What became of an insertion.
enum class PegEnd {
  kIn,       ///< The peg went into the hole as long as it came, but for what the hand gave way.
  kOutside,  ///< It never came below the chamfer.
  kWedged,   ///< Two contacts within the friction cones held it.
  kJammed,   ///< It stood still in the hole that went on, without that.
  kLost,     ///< Neither, but the hand did not keep it.
};
/// "in", "outside", "wedged", "jammed", "lost".
[[nodiscard]] const char* to_string(PegEnd end);

struct InsertionStudy {
  PegScene peg;
  Verdict verdict;
  std::vector<PegTick> ticks;
  std::vector<PegPhase> phases;  ///< Those of less than 5 ms are counted with the one before.
  PegEnd end = PegEnd::kOutside;
  double asked_m = 0.0;                   ///< Depth at the end, if the hand did not give way.
  std::optional<std::size_t> two_points;  ///< The first tick with two,
  std::optional<std::size_t> wedged;      ///< that wedges,
  std::optional<std::size_t> stopped;     ///< and from which on the peg stands still in a hole that comes on.
  std::vector<PegForce> theory;           ///< Of a controller that is a spring; else none.

  [[nodiscard]] double deepest_m() const;
  /// How far F_z is from the theory's at the same depth while both touch so, at most, over the theory's largest there.
  /// NaN where they never do, or without a theory.
  [[nodiscard]] double off_theory(PegTouch touch) const;
};

/// Where a tick is in the jamming diagram of its depth. The diagram is that of small tilts: friction along a peg that
/// leans by theta has the ratios off by theta (mu + 1 / mu) of themselves.
struct JammingPoint {
  double lambda = 0.0;  ///< l / (2 r mu), l below the chamfer.
  double across = 0.0;  ///< F_x / F_z
  double moment = 0.0;  ///< M / (r F_z)
  /// How far it is within the diagram's four lines, over 1 + lambda or 1 / mu: 0 on them, where the peg slides;
  /// negative: outside, where it jams.
  double margin = 0.0;
};
/// Nothing: the peg is not pushed, or is not below the chamfer.
[[nodiscard]] std::optional<JammingPoint> jamming_point(const PegScene& peg, const PegTick& tick);

/// Runs the scene on one thread and watches its peg. Deterministic.
[[nodiscard]] InsertionStudy study_insertion(const Model& model, const PegScene& peg, RunSettings settings = {});

}  // namespace thenar
