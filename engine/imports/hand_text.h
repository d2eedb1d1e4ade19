// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/imports/imported_hand.h"

namespace thenar {

/// Returns the hand as a hand file, with comments on its origin, `origin` a sentence per line, and on approximations.
/// Numbers have 12 digits, so that it reads back the same to 1e-12.
[[nodiscard]] std::string hand_text(const ImportedHand& made, const std::string& origin);

}  // namespace thenar
