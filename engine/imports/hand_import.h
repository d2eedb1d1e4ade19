#pragma once

#include <filesystem>

#include "engine/hand/hand.h"
#include "engine/imports/body_tree.h"
#include "engine/imports/hand_request.h"
#include "engine/imports/imported_hand.h"

namespace thenar {

/// Reads an MJCF or URDF file: its root says which. Throws ConfigError with file and line, and ReadError.
[[nodiscard]] BodyTree read_bodies(const std::filesystem::path& file);

/// Makes the hand that is asked for. Throws ConfigError for what does not fit a hand: see find_chains.
[[nodiscard]] ImportedHand import_hand(const BodyTree& tree, const HandRequest& request);

}  // namespace thenar
