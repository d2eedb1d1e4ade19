// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/hand/hand.h"

namespace thenar {

/// A hand made from another format, with notes on features not converted.
struct ImportedHand {
  Hand hand;
  std::vector<std::string> notes;         ///< Guesses, approximations, locked joints and omissions, a sentence each.
  std::vector<std::string> muscle_notes;  ///< One per muscle: its source and errors.
};

}  // namespace thenar
