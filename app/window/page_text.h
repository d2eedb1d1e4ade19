// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace thenar::window {

/// The page as served, and the policy for its browser.
struct PageText {
  std::string html;
  std::string content_security_policy;
};

/// Returns the built page, showing a recording or what is live. Its own scripts get a nonce, so that a browser runs no
/// others. Throws FileError if it cannot be read or is no page of ours.
[[nodiscard]] PageText read_page(const std::filesystem::path& file, bool recording);

}  // namespace thenar::window
