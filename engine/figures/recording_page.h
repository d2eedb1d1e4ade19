// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace thenar {

/// The window's page with a recording in it, as one file that needs no other: HTML. It has what the page shows, and
/// ends where the recording was cut off. Throws FileError if the recording cannot be read, has no states or none that
/// could be drawn, or if the page was not built.
[[nodiscard]] std::string recording_page(const std::filesystem::path& recording);

}  // namespace thenar
