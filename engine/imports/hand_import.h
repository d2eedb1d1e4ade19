// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/hand/hand.h"
#include "engine/imports/body_tree.h"
#include "engine/imports/hand_request.h"
#include "engine/imports/imported_hand.h"

namespace thenar {

/// Reads an MJCF or URDF file, distinguished by its root. Throws ConfigError with file and line, and ReadError.
[[nodiscard]] BodyTree read_bodies(const std::filesystem::path& file);

/// Makes the requested hand. Throws ConfigError for features that a hand cannot have: see find_chains.
[[nodiscard]] ImportedHand import_hand(const BodyTree& tree, const HandRequest& request);

}  // namespace thenar
