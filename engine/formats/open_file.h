// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>

namespace thenar {

/// An open file that is closed, and its lock released, at the end of the scope.
struct OpenFile {
  int descriptor;  ///< -1 if it could not be opened, with the reason in errno.

  OpenFile(const std::filesystem::path& file, int flags) : descriptor(open(file.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~OpenFile() {
    if (descriptor >= 0) close(descriptor);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
};

}  // namespace thenar
