// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "engine/hand/hand.h"

namespace thenar {

/// Returns true if the file describes a hand rather than a scene. Throws FileError.
[[nodiscard]] bool is_hand_file(const std::filesystem::path& file);

/// Reads a hand file (SI units; layout of configs/hand.yaml). Throws ConfigError or FileError.
[[nodiscard]] Hand load_hand(const std::filesystem::path& file);

/// Returns the text of a hand file, which reads back as the hand to 1e-12.
[[nodiscard]] std::string hand_file_text(const Hand& hand);

}  // namespace thenar
