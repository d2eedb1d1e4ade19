#pragma once

#include <string>
#include <vector>

#include "engine/hand/hand.h"

namespace thenar {

/// A hand that was made of somebody else's description, and what of that is not in it.
struct ImportedHand {
  Hand hand;
  std::vector<std::string> notes;         ///< What was guessed, approximated, locked and left out, a sentence each.
  std::vector<std::string> muscle_notes;  ///< One a muscle: what it was made of, and its errors.
};

}  // namespace thenar
