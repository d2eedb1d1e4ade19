#pragma once

#include <filesystem>

#include "engine/grasp/hand.h"

namespace thenar {

/// Reads a hand file (SI units; layout of configs/hand.yaml). Throws ConfigError or FileError.
[[nodiscard]] Hand load_hand(const std::filesystem::path& file);

}  // namespace thenar
