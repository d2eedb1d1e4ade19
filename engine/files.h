#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace thenar {

/// A file that cannot be read or written, or does not hold what it should (exit code 3): "path: what is wrong".
class FileError : public std::runtime_error {
 public:
  FileError(const std::filesystem::path& file, const std::string& what)
      : std::runtime_error(file.string() + ": " + what) {}
};

/// The ending of the file's name in small letters: ".ply".
[[nodiscard]] std::string ending_of(const std::filesystem::path& file);

/// All bytes of a file. Throws FileError if it cannot be read.
[[nodiscard]] std::string read_file(const std::filesystem::path& file);

/// Replaces a file by these bytes, whole or not at all; what is no regular file, such as a pipe, is written to. Throws
/// FileError.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// Makes a folder for results and proves that it can be written to. Throws FileError.
void prepare_folder(const std::filesystem::path& folder);

}  // namespace thenar
