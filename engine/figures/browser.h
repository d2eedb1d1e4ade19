// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace thenar {

/// A page in a browser without a window: in Chromium, or Chrome, whichever is installed; the variable CHROMIUM names
/// another. It is steered by the Chrome DevTools Protocol.
class Browser {
 public:
  /// Opens a page, which is as wide and as high as this [px]. Throws FileError if no browser is there, or if it fails.
  Browser(const std::string& html, int width, int height);
  ~Browser();

  /// Runs a script of the page, and returns what it, or its promise, comes to. Throws FileError.
  nlohmann::json evaluate(std::string_view script);
  /// Returns a picture of the page (PNG). Throws FileError.
  [[nodiscard]] std::string picture();

  /// A folder for files that are needed no longer than this.
  [[nodiscard]] const std::filesystem::path& folder() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace thenar
