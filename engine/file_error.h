#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace thenar {

/// A file that cannot be read or written, or does not hold what it should (exit code 3): "path: what is wrong".
class FileError : public std::runtime_error {
 public:
  FileError(const std::filesystem::path& file, const std::string& what)
      : std::runtime_error(file.string() + ": " + what) {}
};

}  // namespace thenar
