#pragma once

#include <string>

#include "engine/model.h"
#include "engine/recording.h"

namespace thenar {

/// What became of a grasp.
enum class Outcome {
  kHeld,          ///< Never lost, every finger loaded, forces steady.
  kSlipping,      ///< A finger slid, or lost its load.
  kUnstable,      ///< The object left its target, or the forces chatter.
  kSolverFailed,  ///< A solve found no answer, or there is none.
  kRefused,       ///< The scene is none.
};

/// As reports have it: "held", "slipping", "unstable", "solver failed", "refused".
[[nodiscard]] const char* name(Outcome outcome);

struct Verdict {
  Outcome outcome = Outcome::kHeld;
  std::string reason;  ///< In words; empty if it is held.
};

/// How much of a finger's force changes to and fro from tick to tick: rms of half the second difference of the normal force
/// over its mean, the worst finger's, over the last 0.3 s. Grip that settles has 1e-4, chatter that alternates its amplitude
/// twice. NaN where no finger is loaded.
[[nodiscard]] double force_chatter(const Recording& recording);

/// The verdict on a run that has ended.
[[nodiscard]] Verdict verdict(const Model& model, const Recording& recording);

}  // namespace thenar
