// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "engine/control/pose_loop.h"
#include "engine/grasp/model.h"

namespace thenar {

/// Share of the largest stable gains from which a loop counts as near its limit.
inline constexpr double kNearLimit = 0.8;

/// The state of the object's pose loop, and its limits.
struct LoopMargin {
  int phase = -1;      ///< Phase of the task whose gains these are; -1: the scene's.
  PoseMode slowest;    ///< Mode of the largest pole.
  PoseMode limiting;   ///< Mode that grows first as the gains rise to their limit.
  double share = 0.0;  ///< Gains over their largest stable multiple.
  int delay = 0;       ///< Its delay beside the sampling [steps].
  int most_delay = 0;  ///< Largest stable delay [steps]; -1: none.
  // Remedies that leave it kNearLimit of the limit, where it is near:
  int safe_delay = 0;                     ///< Largest delay for that [steps]; -1: none.
  double position = 0.0, rotation = 0.0;  ///< Factors of the gains of the position or the rotation alone; 0: none.

  /// Returns false where it is unstable with the least gains, too: as a grasp that the start does not have yet.
  [[nodiscard]] bool is_known() const { return std::isfinite(share); }
  [[nodiscard]] bool is_near() const { return is_known() && share >= kNearLimit; }
};

/// Computes the margin for the scene's gains, or those of phase `phase` of its task.
[[nodiscard]] LoopMargin loop_margin(const Model& model, const PoseLoop& loop, int phase = -1);

/// Returns all margins of a scene with control: of the scene's gains, and of each phase that has its own.
[[nodiscard]] std::vector<LoopMargin> loop_margins(const Model& model);

/// Describes a margin: "slowest pole 0.993 a period, rotation about (0.03, -1.00, 0.02); stable up to a delay of 9 ms,
/// and to 4.2 times its gains".
[[nodiscard]] std::string in_words(const Model& model, const LoopMargin& margin);

/// Describes a loop that is unstable or near its limit, and the remedies: "the object's pose loop does not stand its
/// delay: rotation about (1.00, 0.00, 0.00) of the object has a pole of 1.03 at 200 Hz and 20 ms; a delay of at most 11
/// ms, or control.rotation.p of at most 0.29 N m/rad, would do". Empty for other loops.
[[nodiscard]] std::string trouble_in_words(const Model& model, const LoopMargin& margin);

/// Describes a late loop whose grasp forces run away while the grip builds up, at the last control tick that found
/// some: "while the grip built up, its loop ran away: at 0.032 s it has a pole of 9.14 at 500 Hz and a delay of 2 ms,
/// ...". Pressure centres move with the fingers' forces, and so the grasp forces that the next tick asks for. Empty if
/// the loop is stable there, or not late.
[[nodiscard]] std::string runaway_in_words(const Model& model, const ControlReport& solved, double time_s);

}  // namespace thenar
