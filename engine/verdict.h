#pragma once

#include <string>

#include "engine/model.h"
#include "engine/recording.h"

namespace thenar {

/// What became of a grasp.
enum class Outcome {
  kHeld,          ///< Never lost, every finger loaded and without slip, forces steady.
  kSlipping,      ///< A finger slid, or lost its load.
  kUnstable,      ///< The forces chatter.
  kOffTarget,     ///< The object left its target though no finger slid and no force chattered.
  kSolverFailed,  ///< A solve found no answer, or there is none.
  kRefused,       ///< The scene is none.
};

/// As reports have it: "held", "slipping", "unstable", "off target", "solver failed", "refused".
[[nodiscard]] const char* name(Outcome outcome);

struct Verdict {
  Outcome outcome = Outcome::kHeld;
  std::string reason;  ///< In words; empty if it is held.
};

/// How much of a finger's force changes to and fro: half the mean size of its second difference, over the mean force,
/// of the worst finger over the last 0.3 s; the larger of that from tick to tick and that from frame to frame (control
/// period and delay). A force that alternates between F + a and F - a has 2 a / F, a ramp none, one jump among n ticks
/// 1/n of its share. NaN where no finger is loaded.
[[nodiscard]] double force_chatter(const Recording& recording);

/// The verdict on a run that has ended. Of several causes the first in time: chatter counts up to the first of the others,
/// and where there is one, only if it is twice as much as steady grips may have. A contact solver that failed comes
/// before all. Without control nobody minds the object: only solves and chatter count.
[[nodiscard]] Verdict verdict(const Model& model, const Recording& recording);

}  // namespace thenar
