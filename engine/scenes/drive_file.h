// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/grasp/scene.h"
#include "engine/hand/hand.h"

namespace thenar {

/// Reads what drives a hand by time: `time_s`, rising, and for all joints a column `<joint>_Nm`, or for all muscles
/// one `<muscle>_N`, as signals.csv has them; other columns are not read. Throws FileError, and ReadError if there is
/// no such file.
[[nodiscard]] DriveTable load_drive(const std::filesystem::path& file, const Hand& hand);

}  // namespace thenar
