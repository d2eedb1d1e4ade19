// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "engine/grasp/scene.h"

namespace thenar {

// All bounds of a verdict.
inline constexpr double kMeasuredFrom_s = 0.3;  ///< Time from which slip counts: the grip has built up.
inline constexpr double kLoadedFrom_s = 0.1;    ///< Time from which fingers must carry load: the grip is closed.
inline constexpr double kUnloaded_s = 0.05;  ///< Time with fewer than two loaded fingers after which there is no grip.
inline constexpr double kSlidesWhole = 0.9;  ///< Sliding share of its force at which a patch slides as a whole.
inline constexpr double kSlipping_m = 0.1e-3;  ///< Total such slip at which a finger slips; less is micro-slip.
/// Net way of a patch on the object, over its pulp's radius, at which a finger slips, however little of it slides at a
/// time: a fifth of the radius of a patch under 2 N. The thumb that carries a mug turns by 15 degrees, gets on by 0.055
/// and rests; at rest it is 1e-5 in 100 s.
inline constexpr double kWalks = 0.07;
inline constexpr double kOffTarget_m = 10e-3;
inline constexpr double kOffTarget_rad = 20.0 * std::numbers::pi / 180.0;
/// Chatter of forces. Steady grips have 1e-9 to 2e-4, 2e-3 in steps of 20 ms; loops and springs beyond their limits
/// 0.014 and more. Before anything else goes wrong it must be twice as much to be the cause.
inline constexpr double kChatters = 0.01;
/// Share of its largest force by which a muscle that acts may pull harder. Isometric forces are known to no better, and
/// muscles that are asked for their largest force pull a little harder wherever they are stretched a little.
inline constexpr double kPullsOver = 0.05;
inline constexpr double kNotConverged = 1e-2;  ///< Residual above which a contact solve has not converged.
inline constexpr double kMostUnsolved = 0.01;  ///< Largest share of such ticks in a valid run.

/// Outcome of a grasp, the least grave first. If several apply, the gravest is the word; the reason names all.
enum class Outcome {
  kHeld,          ///< Nothing of the following.
  kTaskDone,      ///< Nothing of the following, and all phases of the task are done.
  kUnknown,       ///< Records of ticks were lost, or the run was interrupted: nobody knows.
  kOverLimits,    ///< A joint left its range, or a muscle was asked for more than it has or was stretched beyond it.
  kOffTarget,     ///< The object was 10 mm or 20 degrees off its target; the fingers hold it.
  kSlipping,      ///< A patch slid by 0.1 mm as a whole, or walked (kWalks), or a finger lost its load.
  kResting,       ///< The hand does not hold the object, but the environment carries it.
  kTaskFailed,    ///< A phase did not come to its end, or the object is not where the task should leave it.
  kUnstable,      ///< The forces chatter, or the object swings wider and wider.
  kLost,          ///< The hand no longer holds the object: its grip is open, or a finger has slid off its place.
  kSolverFailed,  ///< A solve found no answer, or there is none.
  kRefused,       ///< The scene was rejected.
};
inline constexpr std::array kOutcomes = {Outcome::kHeld,       Outcome::kTaskDone,     Outcome::kUnknown,
                                         Outcome::kOverLimits, Outcome::kOffTarget,    Outcome::kSlipping,
                                         Outcome::kResting,    Outcome::kTaskFailed,   Outcome::kUnstable,
                                         Outcome::kLost,       Outcome::kSolverFailed, Outcome::kRefused};

/// Returns the word of all reports: "held", "task done", "unknown", "over limits", "off target", "slipping", "resting",
/// "task failed", "unstable", "lost", "solver failed", "refused".
[[nodiscard]] const char* to_string(Outcome outcome);

/// A limit of the hand that a run has passed.
struct Excess {
  std::string name;      ///< Name of the joint or muscle.
  bool muscle = false;   ///< Units: N for a muscle, rad for a joint.
  bool pulled = false;   ///< The muscle pulled so hard; else it was asked to.
  double limit = 0.0;    ///< The muscle's largest force, or that end of the joint's range which was passed.
  double value = 0.0;    ///< Worst value.
  double at_s = 0.0;     ///< Time of the worst value.
  double first_s = 0.0;  ///< Time at which the limit was first passed.
};
/// Returns the excess and its time in words: "the muscle FDPI would need 2600 N at 1.2 s, 13 times its 197.3 N (first
/// passed at 0.9 s)", or that it "pulled with 260 N".
[[nodiscard]] std::string in_words(const Excess& excess);

struct Verdict {
  Outcome outcome = Outcome::kHeld;
  std::string reason = {};  ///< In words; empty if it is held.
  std::optional<double> lost_s = {};
  std::vector<Excess> beyond = {};  ///< Muscles first, each kind in the order of the hand.
  /// Share of a finger's force that changes to and fro: half the mean size of its second difference, over the mean
  /// force, of the worst finger over the last 0.3 s; the larger of that from tick to tick and that from frame to frame
  /// (control period and delay). A force that alternates between F + a and F - a has 2 a / F, a ramp none, one jump
  /// among n ticks 1/n of its share. NaN where no finger is loaded.
  double force_chatter = std::numeric_limits<double>::quiet_NaN();
};

/// Returns the word and the reason: "held", "slipping: the thumb slipped 0.42 mm from 0.512 s on".
[[nodiscard]] std::string in_words(const Verdict& verdict);

/// Returns true for a held grasp or a task that is done.
[[nodiscard]] inline bool is_fine(Outcome outcome) {
  return outcome == Outcome::kHeld || outcome == Outcome::kTaskDone;
}

/// Returns true if a run has failed. Without a controller nothing is asked of the grasp: the word is as true, but only
/// kSolverFailed, kRefused and kUnknown fail.
[[nodiscard]] bool fails(const Scene& scene, Outcome outcome);

}  // namespace thenar
